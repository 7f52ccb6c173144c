"""Cells and arms: in which of the paper's worlds a run took place, and which algorithm it was."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from slcs2_jax.config import Settings
from slcs2_jax.config.chosen import with_search
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.model import ENVIRONMENTS, RANGES
from slcs2_jax.config.registry import any_name
from slcs2_jax.config.worlds import worlds_of


class Cell(NamedTuple):
    """An environment type and a range."""

    environment: str
    range: str

    @property
    def name(self) -> str:
        """open_short: the name of its folder."""
        return f"{self.environment}_{self.range}"

    @property
    def title(self) -> str:
        """As a person reads it."""
        return f"{self.range} {self.environment.replace('_', ' ')}"


OVERALL = "overall"  # in place of an environment: all of them together
CELLS = tuple(Cell(environment, range) for range in RANGES for environment in ENVIRONMENTS)
# The paper's places: its eight cells, each range followed by all of its types together.
PLACES = tuple(Cell(environment, range) for range in RANGES for environment in (*ENVIRONMENTS, OVERALL))
PLAIN = "slcs2"  # the arm that is the paper's algorithm with its main grammar
DESIGNED = "designed"

_TITLES = {
    PLAIN: "SLCS2",
    "informed": "informed search",
    "random": "random search",
    "starters": "the best of two starters",
    "informed_1000000_starts": "random search with knowledge",
    "random_reflex_knowledge_packets_first": "knowledge alone",
    "informed_fewest": "informed, no tournament",
    "informed_random": "informed, random rules in children",
    "racing_inherit_quality_4_starts_reflex_knowledge": "informed, no population of the fittest",
    "tournament_best_racing_inherit_quality_4_starts_reflex_knowledge": "informed, no final",
    "ailta": "no novelty (AILTA)",
    "no_exchange": "no exchange",
    DESIGNED: "designed",
    "channel": "grammar channel",
    "power": "grammar power",
    "both": "grammar both",
}
# The settings that tell arms apart, and those that tell worlds apart.
ALGORITHM = (
    "acceptance", "exchange", "grammar", "search.name", "search.parent", "search.variation", "search.homogeneous",
    "search.racing", "search.inherit_quality", "search.starts", "search.episodes", "knowledge.mode", "knowledge.start",
    "learning.initial_quality", "rules.distinct", "worlds",
)  # fmt: skip
WORLD = ("environment", "range")
_EPISODES = "_episodes"  # ends the name of an arm whose searches stop by what they have spent
_AT = " at "  # between an arm and the settings in which it differs from the rest of its study


def cell_of(settings: Settings) -> Cell:
    """The cell of a run."""
    return Cell(settings.world.environment, settings.world.range)


def cell_named(name: str) -> Cell:
    """The place of a name such as open_short or overall_long; raises KeyError."""
    return {place.name: place for place in PLACES}[name]


def arm_of(settings: Settings, policy: str | None = None) -> str:
    """The arm's name: what is not as in the paper's algorithm, `slcs2` if nothing is; the name of its folder.

    `policy` is a behaviour made by hand, by its name or path, in place of rules that evolve.
    """
    if policy is not None:
        return Path(policy).stem
    search, usual = settings.search, _usual(settings.search.name)
    parts = [] if search.name == PLAIN else [search.name]
    parts += [getattr(search, name) for name in ("parent", "variation") if _other(search, usual.search, name)]
    if search.homogeneous:
        parts.append("homogeneous")
    if search.acceptance != usual.search.acceptance:
        parts.append(search.acceptance)
    for name in ("racing", "inherit_quality"):
        if _other(search, usual.search, name):
            parts.append(name if getattr(search, name) else f"no_{name}")
    if _other(search, usual.search, "starts"):
        parts.append(f"{search.starts}_starts")
    parts += _known(settings, usual)
    if not search.exchange:
        parts.append("no_exchange")
    if settings.rules.distinct:
        parts.append("distinct")
    if settings.worlds:
        parts.append(f"{len(worlds_of(settings))}_worlds")
    if settings.rules.grammar != "main":
        parts.append(Path(settings.rules.grammar).stem)
    if search.episodes is not None:
        parts += [*([] if parts else [PLAIN]), f"{search.episodes}{_EPISODES}"]
    return "_".join(parts) or PLAIN


def _known(settings: Settings, usual: Settings) -> list[str]:
    """How knowledge and initial quality differ from what is usual with a search."""
    knowledge, parts = settings.knowledge, []
    if knowledge.mode != usual.knowledge.mode:
        parts.append(f"{knowledge.mode}_knowledge".replace("none", "no"))
    if knowledge.mode == "reflex" and knowledge.start != usual.knowledge.start:
        parts.append(f"{knowledge.start}_first")
    if settings.learning.initial_quality != usual.learning.initial_quality:
        parts.append(f"initial_quality_{settings.learning.initial_quality:g}")
    return parts


@functools.lru_cache(maxsize=32)
def _usual(search: str) -> Settings:
    """The default settings with a search and what it brings."""
    with any_name():
        return with_search(Settings(), search)


def _other(one: object, usual: object, name: str) -> bool:
    return bool(getattr(one, name) != getattr(usual, name))


def arm_at(arm: str, changes: str) -> str:
    """The name of an arm with other settings than the rest of its study: `slcs2 at swarm.speed=4`."""
    return f"{arm}{_AT}{changes}" if changes else arm


def arm_title(name: str) -> str:
    """As tables and figures print it."""
    arm, at, changes = name.partition(_AT)
    plain, spent = arm, ""
    if arm.endswith(_EPISODES):
        plain, _, number = arm.removesuffix(_EPISODES).rpartition("_")
        spent = f", {number} episodes"
    return _TITLES.get(plain, terminal(plain.replace("_", " "))) + spent + at + changes


def ordered(names: Iterable[str]) -> list[str]:
    """The paper's algorithm first, then the order of the paper, then by name; each followed by itself elsewhere."""
    known = list(_TITLES)

    def place(name: str) -> tuple[int, str, str]:
        arm, _, changes = name.partition(_AT)
        return (known.index(arm) if arm in known else len(known)), arm, changes

    return sorted(set(names), key=place)
