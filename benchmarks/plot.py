"""The picture of the scaling benchmark: a panel for every factor, log-log, black on white."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

from slcs2_jax.results.files import write_whole

LABELS = {
    "agents": "agents",
    "rules": "rules per agent",
    "walls": "walls",
    "batch": "episodes at once",
    "devices": "devices",
}


def draw(tables: Mapping[str, Sequence[Mapping[str, Any]]], path: Path, devices: str) -> None:
    """Draw rates with their spread; a point at 0, which has no place on a logarithmic axis, becomes a dashed line."""
    matplotlib.use("Agg")
    from matplotlib import pyplot, ticker

    figure, axes = pyplot.subplots(1, len(tables), figsize=(3.0 * len(tables), 3.2), squeeze=False, sharey=True)
    for axis, (factor, rows) in zip(axes[0], tables.items(), strict=True):
        shown = [row for row in rows if row["value"] > 0]
        rates = [row["env_steps_per_second"] for row in shown]
        below = [rate["median"] - rate["low"] for rate in rates]
        above = [rate["high"] - rate["median"] for rate in rates]
        values = [row["value"] for row in shown]
        axis.errorbar(values, [rate["median"] for rate in rates], yerr=[below, above], color="black", marker="o",
                      markersize=4, linewidth=1, capsize=2)  # fmt: skip
        for row in rows:
            if row["value"] == 0:
                axis.axhline(row["env_steps_per_second"]["median"], color="0.4", linestyle="--", label=f"no {factor}")
                axis.legend(frameon=False)
        axis.set_xscale("log", base=2)
        axis.set_yscale("log")
        axis.set_xticks(values, [str(value) for value in values])
        axis.minorticks_off()
        axis.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        axis.yaxis.set_major_formatter(ticker.EngFormatter())
        axis.set_xlabel(LABELS[factor])
        axis.grid(axis="y", color="0.85")
    axes[0][0].set_ylabel("env-steps per second")
    figure.suptitle(devices, fontsize="medium")
    figure.tight_layout()
    whole = io.BytesIO()
    figure.savefig(whole, format=path.suffix[1:], dpi=150)
    pyplot.close(figure)
    write_whole(path, lambda file: file.write(whole.getvalue()))
