"""How figures are drawn and written: in one style, without a date or a version, so that equal ones have equal bytes."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from slcs2_jax.results.files import write_whole

SUFFIXES = (".png", ".svg", ".pdf")
_RC = {
    "font.size": 8.0,
    "svg.hashsalt": "slcs2_jax",
    "svg.fonttype": "path",
    "figure.dpi": 100.0,
    "text.parse_math": False,  # names of files may hold a $
}
_UNDATED: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None, "Producer": None},
}


def save(figure: Callable[[], Figure], stem: Path) -> list[Path]:
    """Draw and write STEM.png and STEM.svg."""
    with own_style():
        drawn = figure()
        paths = [stem.with_suffix(suffix) for suffix in (".png", ".svg")]
        for path in paths:
            write_figure(drawn, path)
    return paths


def write_figure(drawn: Figure, path: Path) -> None:
    """Write a figure to a new file, in the format of its suffix, one of SUFFIXES."""
    buffer = io.BytesIO()
    drawn.savefig(buffer, format=path.suffix[1:], metadata=_UNDATED[path.suffix], dpi=200)
    content = buffer.getvalue()
    write_whole(path, lambda file: file.write(content))


@contextmanager
def own_style() -> Iterator[None]:
    """Matplotlib's defaults and ours, whatever the user's own are."""
    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a name in letters that the font has not
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_RC)  # type: ignore[arg-type]
        yield
