"""Cells and arms: in which of the paper's worlds a run took place, and which algorithm it was."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from slcs2_jax.config import Settings
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.model import ENVIRONMENTS, RANGES


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
    "search.racing", "search.inherit_quality", "knowledge.mode",
)  # fmt: skip
WORLD = ("environment", "range")
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
    search = settings.search
    parts = [] if search.name == PLAIN else [search.name]
    informed = search.name == "informed"
    parents = "tournament" if informed else "fewest"
    parts += [part for part, usual in ((search.parent, parents), (search.variation, "exchange")) if part != usual]
    if search.homogeneous:
        parts.append("homogeneous")
    if search.acceptance != ("best" if informed else "domination"):
        parts.append(search.acceptance)
    for name in ("racing", "inherit_quality"):
        if getattr(search, name) != informed:
            parts.append(f"no_{name}" if informed else name)
    if settings.knowledge.mode != ("reflex" if informed else "none"):
        parts.append(f"{settings.knowledge.mode}_knowledge".replace("none", "no"))
    if not search.exchange:
        parts.append("no_exchange")
    if settings.rules.grammar != "main":
        parts.append(Path(settings.rules.grammar).stem)
    return "_".join(parts) or PLAIN


def arm_at(arm: str, changes: str) -> str:
    """The name of an arm with other settings than the rest of its study: `slcs2 at swarm.speed=4`."""
    return f"{arm}{_AT}{changes}" if changes else arm


def arm_title(name: str) -> str:
    """As tables and figures print it."""
    arm, at, changes = name.partition(_AT)
    return _TITLES.get(arm, terminal(arm.replace("_", " "))) + at + changes


def ordered(names: Iterable[str]) -> list[str]:
    """The paper's algorithm first, then the order of the paper, then by name; each followed by itself elsewhere."""
    known = list(_TITLES)

    def place(name: str) -> tuple[int, str, str]:
        arm, _, changes = name.partition(_AT)
        return (known.index(arm) if arm in known else len(known)), arm, changes

    return sorted(set(names), key=place)
