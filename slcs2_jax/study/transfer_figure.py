"""The matrix of transfer as a heat map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from slcs2_jax.config.escape import terminal
from slcs2_jax.study.transfer import Source, columns


def transfer_figure(sources: Sequence[Source]) -> Figure:
    """A row for each source, a column for each kind of world; what evolved there is framed."""
    names = columns(sources)
    values = np.array([[one.by_world(kind).mean() for kind in names] for one in sources])
    figure = Figure(figsize=(3.4 + 0.85 * len(names), 1.3 + 0.26 * len(sources)), layout="constrained")
    panel = figure.subplots()
    image = panel.imshow(values, aspect="auto", cmap="cividis")
    middle = (values.min() + values.max()) / 2
    for (row, column), mean in np.ndenumerate(values):
        panel.text(
            column, row, f"{mean:.2f}", ha="center", va="center", color="white" if mean < middle else "black",
            fontsize=6, weight="bold" if sources[row].home == names[column] else "normal",
        )  # fmt: skip
    panel.set_xticks(range(len(names)), names, rotation=30, ha="right")
    panel.set_yticks(range(len(sources)), [terminal(one.title) for one in sources])
    panel.set_xlabel("deployed in (bold: in other worlds of the kind that it evolved in)")
    figure.colorbar(image, label="mean fitness")
    return figure
