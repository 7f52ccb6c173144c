"""A span of an episode in one picture: the layout with its links and flow of packets, or the paths of the agents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from slcs2_jax.looking.recording import Recording
from slcs2_jax.looking.scene import (
    DOWN,
    EMPTY,
    HOLDING,
    JAMMER,
    LINK,
    agent_faces,
    draw_field,
    draw_jammers,
    draw_world,
    extent,
    panels,
)
from slcs2_jax.looking.traffic import traffic
from slcs2_jax.swarm.fate import Fate

FLOW = "#009e73"
WIDEST = 5.0  # points, the line of the busiest pair
LINKED = 0.5  # share of the steps in which two hear each other, from which on they count as linked
RECENT = 100  # steps before the end that say who is linked


def still(
    recordings: Sequence[Recording], titles: Sequence[str], picture: str, *, start: int, end: int, field: str | None
) -> Figure:
    """A picture of one episode, or of several in one world one above the other.

    Args:
        recordings, titles: what to show, and what to call it.
        picture: one of PICTURES.
        start, end: first and last moment of the span.
        field: a radio map at the end of the span under the rest, one of `radio_map.FIELDS`.
    """
    figure, axes = panels(recordings, field)
    within = extent(recordings)
    for ax, one, title in zip(axes, recordings, titles, strict=True):
        first, last = min(start, one.steps), min(end, one.steps)
        if field is not None:
            draw_field(ax, one, field, last, within)
        draw_world(ax, one, within)
        for mark in draw_jammers(ax, one):
            mark.show(last)
        ax.plot(one.jammer_x[first : last + 1], one.jammer_y[first : last + 1], ":", color=JAMMER, linewidth=0.8)
        ax.set_title(f"{title}; steps {first:,d} to {last:,d}", loc="left", fontsize=8)
        handles = PICTURES[picture](ax, one, first, last)
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7, frameon=False)
    return figure


def _layout(axes: Any, recording: Recording, start: int, end: int) -> list[Line2D]:
    """Last places, who heard whom, and how many packets went from whom to whom."""
    places = [recording.place(end, node) for node in range(recording.agents + 2)]
    recent = [recording.neighbours(step) for step in range(max(start, end - RECENT), end)]
    if recent:
        for node, agent in np.argwhere(np.mean(recent, axis=0) >= LINKED).tolist():
            axes.plot(*zip(places[node], places[agent], strict=True), color=LINK, linewidth=0.7, zorder=1.5)
    flow = traffic(recording, start, end)[..., Fate.DELIVERED]
    most = max(int(flow.max()), 1)
    for sender, receiver in np.argwhere(flow).tolist():
        width = WIDEST * float(np.sqrt(flow[sender, receiver] / most))
        axes.annotate(
            "",
            places[receiver],
            xytext=places[sender],
            arrowprops={
                "arrowstyle": "-|>,head_width=0.25,head_length=0.5",
                "connectionstyle": "arc3,rad=0.08",  # so that both directions are seen
                "color": FLOW,
                "linewidth": max(width, 0.3),
                "alpha": 0.75,
                "shrinkA": 3,
                "shrinkB": 3,
            },
            zorder=3,
        )
    _draw_agents(axes, recording, end, agent_faces(recording, end))
    return [
        Line2D(
            [], [], color=FLOW, linewidth=3, label=f"packets handed over; the widest: {most:,d}, width as their root"
        ),
        Line2D([], [], color=LINK, linewidth=1.2, label=f"heard in at least half of the last {RECENT} steps"),
        _dot(HOLDING, "agent with a packet"),
        _dot(EMPTY, "without"),
        *[_dot(DOWN, "down")] * bool(recording.down[end].any()),
    ]


def _paths(axes: Any, recording: Recording, start: int, end: int) -> list[Line2D]:
    """The way of every agent through the span, from the hollow end to the full one."""
    shades = matplotlib.colormaps["viridis"](np.linspace(0, 0.9, recording.agents))
    lines = ("-", "--", "-.", ":")
    for agent in range(recording.agents):
        x, y = recording.x[start : end + 1, agent], recording.y[start : end + 1, agent]
        line = lines[agent % len(lines)]
        axes.plot(x, y, color=shades[agent], linestyle=line, linewidth=1.0, zorder=3)
        axes.plot(x[0], y[0], "o", markersize=4, markerfacecolor=EMPTY, markeredgecolor=shades[agent], zorder=4)
    _draw_agents(axes, recording, end, shades)
    return [
        Line2D([], [], color=shades[0], linewidth=1.2, label="path of an agent, in its own shade and dashes"),
        Line2D(
            [], [], marker="o", color="none", markerfacecolor=EMPTY, markeredgecolor="black", label="where it began"
        ),
        Line2D([], [], marker="o", color="none", markerfacecolor="black", label="where it ended, with its number"),
    ]


def _draw_agents(axes: Any, recording: Recording, moment: int, faces: Any) -> None:
    x, y = recording.x[moment], recording.y[moment]
    axes.scatter(x, y, s=30, c=faces, edgecolors=HOLDING, linewidths=1.0, zorder=5)
    for agent in range(recording.agents):
        axes.annotate(
            str(agent), (x[agent], y[agent]), xytext=(4, 4), textcoords="offset points", fontsize=6.5, zorder=6
        )


def _dot(face: str, label: str) -> Line2D:
    return Line2D([], [], marker="o", color="none", markerfacecolor=face, markeredgecolor=HOLDING, label=label)


PICTURES: dict[str, Callable[[Any, Recording, int, int], list[Line2D]]] = {"layout": _layout, "paths": _paths}
