"""The notebooks of the documentation as pages: their text, their code, and what it came to when they were run."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

NOTEBOOKS = Path(__file__).resolve().parent.parent / "docs" / "notebooks"
PICTURES = {"image/png": "png", "image/gif": "gif"}


def notebook_files() -> dict[str, str | bytes]:
    """Path below docs/ and content of every page, and of the pictures on it."""
    found: dict[str, str | bytes] = {}
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        found |= page(path.stem, json.loads(path.read_text(encoding="utf-8")))
    return found


def page(name: str, notebook: dict[str, Any]) -> dict[str, str | bytes]:
    """One notebook's page and its pictures. Raises ValueError for an output that it cannot show."""
    parts, pictures = [], {}
    for cell in notebook["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(re.sub(r"\]\((\w+)\.ipynb\)", r"](\1.md)", source))
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            if output["output_type"] == "stream":
                parts.append(f"```text\n{''.join(output['text']).rstrip()}\n```")
                continue
            kind = next((kind for kind in PICTURES if kind in output.get("data", ())), None)
            if kind is None:
                raise ValueError(f"{name}: no way to show {output['output_type']}; accepted are text and pictures")
            picture = f"{name}_{len(pictures)}.{PICTURES[kind]}"
            pictures[f"notebooks/{picture}"] = base64.b64decode("".join(output["data"][kind]))
            parts.append(f"![What this cell draws]({picture})")
    title, _, rest = parts[0].partition("\n")
    parts[0] = f"{title}\n\n*[Download this notebook]({name}.ipynb)*\n{rest}"
    return {f"notebooks/{name}.md": "\n\n".join(parts) + "\n", **pictures}
