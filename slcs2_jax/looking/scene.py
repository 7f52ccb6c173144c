"""A moment of an episode, drawn: the world, agents with their packets and paths, links, transmissions, a radio map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from slcs2_jax.looking import radio_map
from slcs2_jax.looking.recording import Recording
from slcs2_jax.looking.traffic import telling, traffic
from slcs2_jax.swarm.fate import Fate

# colour, line, label; told apart without colour by the line
FATES: dict[Fate, tuple[str, Any, str]] = {
    Fate.DELIVERED: ("#009e73", "-", "delivered"),
    Fate.JAMMED: ("#cc0066", (0, (1, 1)), "lost to the jammer"),
    Fate.INTERFERENCE: ("#d55e00", (0, (4, 2)), "lost to interference"),
    Fate.REFUSED: ("#b8860b", (0, (6, 1, 1, 1)), "receiver busy"),
    Fate.WEAK: ("#777777", (0, (2, 4)), "too weak"),
}
HOLDING, EMPTY, LINK, TRAIL, WALL = "#0072b2", "#ffffff", "#c9d6e2", "#8fb4d0", "#555555"
JAMMER, DOWN = "#cc0066", "#999999"
FIELD_LABELS = {"power": "mean power of the strongest sender (dBm)", "sinr": "mean SINR of the strongest sender (dB)"}
FIELD_SPAN = 30  # dB of a radio map that are told apart, from the limit of reception on
MARGIN = 15.0  # m around everything
WIDTH = 9.0  # inches of a figure
TRAIL_MOMENTS = 60  # drawn of each agent's path


def extent(recordings: Sequence[Recording]) -> tuple[float, float, float, float]:
    """Left, right, bottom and top, m, of a map that holds everything that happens."""
    x, y = [0.0], [0.0]
    for one in recordings:
        scenario = one.scenario
        x += [float(scenario.sink[0]), float(one.x.min()), float(one.x.max())]
        y += [float(scenario.sink[1]), float(one.y.min()), float(one.y.max())]
        x += [*one.jammer_x.ravel().tolist()]
        y += [*one.jammer_y.ravel().tolist()]
        for at, along, across in ((scenario.vertical, x, y), (scenario.horizontal, y, x)):
            along += at[:, 0].tolist()
            across += [*at[:, 1].tolist(), *at[:, 2].tolist()]
    return min(x) - MARGIN, max(x) + MARGIN, min(y) - MARGIN, max(y) + MARGIN


def panels(recordings: Sequence[Recording], field: str | None) -> tuple[Figure, list[Any]]:
    """A figure with axes for each of the recordings, one above the other, as high as the map asks for."""
    left, right, bottom, top = extent(recordings)
    wide = WIDTH - (0.9 if field is None else 1.9)
    high = (wide * (top - bottom) / (right - left) + 0.65) * len(recordings) + 0.45
    figure = Figure(figsize=(WIDTH, round(50 * high) / 50), layout="constrained")  # even pixels: video wants them
    return figure, figure.subplots(len(recordings), 1, squeeze=False)[:, 0].tolist()


def draw_field(
    axes: Any, recording: Recording, name: str, moment: int, within: tuple[float, float, float, float]
) -> Any:
    """A radio map under the rest, with a bar that says what its shades mean; the image.

    The shades end where nothing can be received: below P_rs, or below the SINR threshold.
    """
    radio = recording.settings.radio
    limit = radio.receive_threshold_dbm if name == "power" else radio.sinr_threshold_db
    image = axes.imshow(
        radio_map.field(recording, name, moment, within),
        origin="lower",
        extent=within,
        cmap="Greys",
        vmin=limit,
        vmax=limit + 2 * FIELD_SPAN,  # pale enough for what is drawn upon it
        interpolation="nearest",
        zorder=0,
    )
    shades = np.linspace(limit, limit + FIELD_SPAN, 4 * FIELD_SPAN + 1)
    ticks = np.linspace(limit, limit + FIELD_SPAN, 6)
    bar = axes.figure.colorbar(image, ax=axes, pad=0.01, fraction=0.04, boundaries=shades, ticks=ticks, extend="max")
    bar.set_label(FIELD_LABELS[name], fontsize=7)
    bar.ax.tick_params(labelsize=7)
    return image


def draw_world(axes: Any, recording: Recording, within: tuple[float, float, float, float]) -> None:
    """Everything that stands still: walls, source and sink; axes in m."""
    scenario, half = recording.scenario, recording.scenario.wall_thickness / 2
    for x, low, high in scenario.vertical.tolist():
        axes.add_patch(Rectangle((x - half, low), 2 * half, high - low, color=WALL, linewidth=0, zorder=2))
    for y, low, high in scenario.horizontal.tolist():
        axes.add_patch(Rectangle((low, y - half), high - low, 2 * half, color=WALL, linewidth=0, zorder=2))
    axes.plot(0, 0, "s", color="black", markersize=8, zorder=4)
    axes.plot(*scenario.sink, "*", color="black", markersize=12, zorder=4)
    for name, (x, y) in (("source", (0.0, 0.0)), ("sink", scenario.sink.tolist())):
        axes.annotate(name, (x, y), xytext=(0, -13), textcoords="offset points", ha="center", fontsize=7, zorder=6)
    left, right, bottom, top = within
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")


class JammerMark:
    """A jammer and its reach on some axes."""

    def __init__(self, axes: Any, recording: Recording, jammer: int) -> None:
        """Draw it where it starts."""
        several = len(recording.scenario.jammers) > 1
        self._recording, self._jammer = recording, jammer
        self._circle = Circle((0, 0), recording.reach(jammer), edgecolor=JAMMER, linestyle=":", zorder=1)
        axes.add_patch(self._circle)
        (self._cross,) = axes.plot([], [], "X", color=JAMMER, markersize=9, zorder=4)
        text = f"jammer {jammer}" if several else "jammer"
        self._text = axes.annotate(text, (0, 0), xytext=(0, -13), textcoords="offset points", ha="center", fontsize=7)
        self.show(0)

    @property
    def moves(self) -> bool:
        """Whether it may ever look otherwise than at the start."""
        return not self._recording.scenario.jammers[self._jammer].plain

    @property
    def artists(self) -> list[Artist]:
        """What it is drawn by."""
        return [self._circle, self._cross, self._text]

    def show(self, moment: int) -> None:
        """Put it where it was at a moment; the reach of one that is silent then is hollow."""
        x, y = self._recording.jammer_places(moment)[self._jammer]
        self._circle.center = x, y
        self._circle.set_facecolor(JAMMER + "12" if self._recording.emits(self._jammer, moment) else "none")
        self._cross.set_data([x], [y])
        self._text.xy = x, y


def draw_jammers(axes: Any, recording: Recording) -> list[JammerMark]:
    """Every jammer with its reach."""
    return [JammerMark(axes, recording, jammer) for jammer in range(len(recording.scenario.jammers))]


def agent_faces(recording: Recording, moment: int) -> list[str]:
    """The colour of each agent at a moment: it has a packet, has none, or is down."""
    states = zip(recording.down[moment].tolist(), recording.holding[moment].tolist(), strict=True)
    return [DOWN if down else HOLDING if held else EMPTY for down, held in states]


def legend_handles(failing: bool = False) -> list[Line2D]:
    """What the marks of a scene mean; of agents that are down only where some can fail."""
    handles = [
        Line2D([], [], color=colour, linestyle=line, linewidth=1.6, label=label)
        for colour, line, label in FATES.values()
    ]
    marks = [(HOLDING, "agent with a packet"), (EMPTY, "without"), *[(DOWN, "down")] * failing]
    handles += [
        Line2D([], [], marker="o", color="none", markerfacecolor=face, markeredgecolor=HOLDING, label=label)
        for face, label in marks
    ]
    return [*handles, Line2D([], [], color=LINK, linewidth=1.2, label="heard each other")]


class Scene:
    """One episode on one pair of axes; `show` moves everything to another moment."""

    def __init__(
        self, axes: Any, recording: Recording, title: str, within: tuple[float, float, float, float], field: str | None
    ) -> None:
        """Draw what stands still, and set up what moves; over a radio map, if one is named."""
        self.recording = recording
        self._within, self._field = within, field
        self._image = None if field is None else draw_field(axes, recording, field, 0, within)
        draw_world(axes, recording, within)
        self._jammers = draw_jammers(axes, recording)
        axes.set_title(title, loc="left", fontsize=8)
        self._links = LineCollection([], colors=LINK, linewidths=0.6, zorder=1.5)
        self._trails = LineCollection([], colors=TRAIL, linewidths=0.9, zorder=2.5)
        self._shafts = {
            fate: LineCollection([], colors=colour, linestyles=[line], linewidths=1.5, zorder=3)
            for fate, (colour, line, _) in FATES.items()
        }
        self._heads = {
            fate: LineCollection([], colors=colour, linewidths=1.5, zorder=3) for fate, (colour, _, _) in FATES.items()
        }
        self._agents = axes.scatter(
            np.zeros(recording.agents), np.zeros(recording.agents), s=26, edgecolors=HOLDING, linewidths=1.0, zorder=5
        )
        self._text = axes.text(
            1, 1.01, "", transform=axes.transAxes, ha="right", va="bottom", fontsize=8, family="monospace"
        )
        for artist in (self._links, self._trails, *self._shafts.values(), *self._heads.values()):
            axes.add_collection(artist)
        self._head = 0.012 * (within[1] - within[0])

    @property
    def moving(self) -> list[Artist]:
        """What `show` changes, in the order of drawing; beside the radio map."""
        arrows = [*self._shafts.values(), *self._heads.values()]
        jammers = [artist for mark in self._jammers if mark.moves for artist in mark.artists]
        return [*jammers, self._links, self._trails, *arrows, self._agents, self._text]

    def show(self, moment: int, since: int) -> None:
        """The swarm at a moment, with the transmissions of all steps since another one, a pair of nodes once each."""
        one = self.recording
        moment, since = min(moment, one.steps), min(since, one.steps)
        places = self._places(moment)
        self._agents.set_offsets(places[: one.agents])
        self._agents.set_facecolors(agent_faces(one, moment))
        for mark in self._jammers:
            mark.show(moment)
        start = max(0, moment - TRAIL_MOMENTS)
        self._trails.set_segments(list(np.stack([one.x[start : moment + 1].T, one.y[start : moment + 1].T], axis=-1)))
        pairs = np.argwhere(one.neighbours(min(moment, one.steps - 1))).tolist()
        self._links.set_segments([(places[node], places[agent]) for node, agent in pairs])
        self._show_transmissions(places, since, moment)
        if self._image is not None and self._field is not None:
            self._image.set_data(radio_map.field(one, self._field, moment, self._within))
        over = "  ended" if moment == one.steps else ""
        self._text.set_text(
            f"step {moment:6,d}   delivered {one.delivered[moment]:3d}   held {int(one.holding[moment].sum()):2d}   "
            f"waiting {one.waiting[moment]:3d}{over}"
        )

    def _places(self, moment: int) -> NDArray[np.float64]:
        return np.array([self.recording.place(moment, node) for node in range(self.recording.agents + 2)])

    def _show_transmissions(self, places: NDArray[np.float64], since: int, moment: int) -> None:
        by_fate: dict[Fate, list[Any]] = {fate: [] for fate in FATES}
        for sender, receiver, fate in telling(traffic(self.recording, since, moment)):
            by_fate[fate].append((places[sender], places[receiver]))
        for fate, segments in by_fate.items():
            self._shafts[fate].set_segments(segments)
            self._heads[fate].set_segments([arrow_head(start, end, self._head) for start, end in segments])


def arrow_head(start: NDArray[np.float64], end: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """The two strokes of an arrow's head at `end`: [3, 2]."""
    along = end - start
    length = float(np.hypot(*along))
    if length == 0:
        return np.stack([end, end, end])
    along = along / length
    across = np.array([-along[1], along[0]])
    tip = end - along * min(size / 2, length / 3)
    return np.stack([tip - size * along + size / 2 * across, tip, tip - size * along - size / 2 * across])
