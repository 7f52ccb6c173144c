"""All settings of one run: typed, frozen, checked when made, each with its unit, limits, status and reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from slcs2_jax.config import plugins
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.field import LEAST, Section, setting
from slcs2_jax.config.jammers import Jammers
from slcs2_jax.config.knowledge import Knowledge
from slcs2_jax.config.model import Learning, Rules, Swarm, Task, World
from slcs2_jax.config.radio import Radio
from slcs2_jax.config.worlds import kinds_of

# Share of the start disc that discs of one clearance in diameter may cover. Random placement one after the other jams
# at about 0.55; below 0.4 it always ends quickly.
START_DISC_SHARE = 0.4


@dataclass(frozen=True)
class Search(Section):
    """Evaluation and search for solutions (docs/model.md)."""

    SECTION: ClassVar[str] = "search"

    name: str = setting(
        "slcs2",
        "what proposes solutions and learns from their evaluations; set by search=",
        status="paper",
        part="search",
    )
    generations: int = setting(
        500, "generations, one new solution each", name="generations", status="paper", low=1, high=10**7
    )
    acceptance: str = setting(
        "domination",
        "which solutions are kept: the collection of the paper, or ailta (ablation)",
        name="acceptance",
        status="paper",
        part="acceptance",
    )
    parent: str = setting("fewest", "which of the solutions kept is varied next", status="paper", part="parent")
    variation: str = setting(
        "exchange", "how it is varied: exchange is the paper's offspring", status="paper", part="variation"
    )
    exchange: bool = setting(
        True, "do offspring take rules from a donor; off is an ablation", name="exchange", status="paper"
    )
    homogeneous: bool = setting(
        False,
        "one rule-set for all agents; contribution is then their sum, and there is nobody to exchange with",
        status="definition",
    )
    batch: int = setting(
        1, "solutions made and evaluated side by side, one generation each", status="definition", low=1, high=10**4
    )
    episodes: int | None = setting(
        None, "most deployments that a search may spend; null leaves it to generations", status="run", low=1, high=10**9
    )
    min_deployments: int = setting(1, "least deployments of a new solution", status="paper", low=1, high=1000)
    max_redeployments: int = setting(
        5,
        "kappa, most further deployments while the mean fitness is above 0",
        reason="a mean of six at most",
        low=0,
        high=1000,
    )
    omega0: float = setting(
        2.0,
        "weight of novelty; omega = omega0 / size of the collection",
        reason="the paper gives the inverse relation",
        low=0,
        high=1e6,
    )
    varrho: float = setting(
        100.0,
        "explorations that cost a parent the whole share of kept rules",
        reason="one unit of the share",
        low=LEAST,
        high=1e9,
    )
    ailta_rejections: int = setting(
        5,
        "ailta: rejections in a row before a worse solution may be accepted",
        reason="ablation only",
        low=0,
        high=10**7,
    )
    ailta_threshold: float = setting(
        0.04, "ailta: first threshold, and its growth", unit="fitness", reason="2 % of the fitness range", low=0, high=2
    )
    ailta_threshold_max: float = setting(
        0.4, "ailta: greatest threshold", unit="fitness", reason="20 % of the fitness range", low=0, high=2
    )
    ailta_patience: int = setting(
        25,
        "ailta: generations without a new best before the threshold grows",
        reason="ablation only",
        low=1,
        high=10**7,
    )
    starts: int = setting(1, "random solutions before parents are chosen", status="definition", low=1, high=10**6)
    inherit_quality: bool = setting(
        False, "do offspring start with the quality that their rules had learnt", status="definition"
    )
    racing: bool = setting(
        False,
        "deploy a new solution again while it may still be better than the best, in place of while its mean is above 0",
        status="definition",
    )
    race_width: float = setting(
        1.0, "racing: half width of the interval, in standard errors", reason="untuned", low=0, high=100
    )
    population: int = setting(10, "acceptance=best: solutions that are kept", reason="untuned", low=1, high=10**4)
    tournament: int = setting(
        2,
        "search.parent=tournament: solutions that are drawn, of which the fittest wins",
        reason="untuned",
        low=1,
        high=10**4,
    )
    finalists: int = setting(
        4,
        "informed: solutions in a final, of which half stay in each round; a power of two",
        reason="untuned",
        low=2,
        high=64,
    )
    final_deployments: int = setting(
        6, "informed: least deployments of each finalist in each round", reason="untuned", low=1, high=1000
    )
    final_share: float = setting(
        0.4,
        "informed: share of search.episodes that the final takes, where that gives each finalist more deployments",
        reason="a few failures in a hundred deployments show in 40, and not in 18",
        low=0,
        high=0.9,
    )
    final_every: int = setting(
        20,
        "informed: generations from final to final, its own included; with search.episodes there is one, at the end",
        reason="untuned",
        low=3,
        high=10**7,
    )
    fresh_deployments: int = setting(
        30, "fresh deployments that measure the winner afterwards", status="run", low=1, high=10**6
    )

    def in_final(self, worlds: int) -> int:
        """Deployments of each finalist in each round of a final; in many worlds, whole rounds through them."""
        share = math.floor(self.final_share * (self.episodes or 0) / (2 * self.finalists - 2))
        return max(self.final_deployments, share) if worlds == 1 else worlds * max(1, share // worlds)

    def cross_check(self) -> None:
        if self.generations % self.batch:  # else a run that goes further would not be as one that went so far at once
            raise refuse("generations", self.generations, f"a multiple of search.batch={self.batch}")
        if self.name == "informed":
            self._check_finals()

    def _check_finals(self) -> None:
        if self.finalists & (self.finalists - 1):
            raise refuse("search.finalists", self.finalists, "a power of two")
        if self.finalists > self.population:
            raise refuse("search.finalists", self.finalists, f"at most search.population={self.population}")
        rounds = 2 * self.finalists - 2
        if self.final_every < rounds + self.finalists:
            raise refuse(
                "search.final_every",
                self.final_every,
                f"at least {rounds + self.finalists}: a final of "
                f"search.finalists={self.finalists} takes {rounds} generations, and needs as many to choose from",
            )
        if self.episodes is None and self.generations % self.final_every:
            raise refuse("generations", self.generations, f"a multiple of search.final_every={self.final_every}")


@dataclass(frozen=True)
class Compute(Section):
    """How the machine is used; results do not depend on it beyond floating point."""

    SECTION: ClassVar[str] = "compute"

    devices: int | None = setting(
        None, "devices to spread the batch over; null takes all (CPU: one per core)", status="run", low=1, high=1024
    )
    slots: int | None = setting(None, "episodes advanced together; null chooses", status="run", low=1, high=10**6)
    chunk: int = setting(
        250,
        "steps between refills of finished slots; rounded to whole sharing periods",
        unit="steps",
        status="run",
        low=1,
        high=10**6,
    )
    cache: bool = setting(True, "keep compiled programs on disk for the next run", status="run")
    native: str = setting(
        "auto",
        "compute by the native chunk, on CPUs: auto where it can, on or nothing, or off: XLA",
        status="run",
        options=("auto", "on", "off"),
    )


@dataclass(frozen=True)
class Checkpoint(Section):
    """How often a run is saved so that it can go on after an interruption; results do not depend on it."""

    SECTION: ClassVar[str] = "checkpoint"

    generations: int | None = setting(
        None,
        "save when an instance has so many unsaved generations; null goes by time",
        status="run",
        low=1,
        high=10**7,
    )
    seconds: float | None = setting(
        60.0,
        "save after so long, or later if all of it would take over 0.5 % of the time; null never",
        unit="s",
        status="run",
        low=0,
        high=1e7,
    )


@dataclass(frozen=True)
class Settings(Section):
    """One run: its world, its agents, its search, and the seeds it is made with."""

    world: World = field(default_factory=World)
    radio: Radio = field(default_factory=Radio)
    jammers: Jammers = field(default_factory=Jammers)
    swarm: Swarm = field(default_factory=Swarm)
    learning: Learning = field(default_factory=Learning)
    rules: Rules = field(default_factory=Rules)
    task: Task = field(default_factory=Task)
    search: Search = field(default_factory=Search)
    knowledge: Knowledge = field(default_factory=Knowledge)
    compute: Compute = field(default_factory=Compute)
    checkpoint: Checkpoint = field(default_factory=Checkpoint)
    seed: int = setting(0, "seed of the first instance; instance i uses seed + i", status="run", low=0, high=2**31 - 1)
    instances: int = setting(8, "instances (worlds and searches) run together", status="run", low=1, high=10**5)
    worlds: tuple[str, ...] = setting(
        (),
        "worlds of one search for all of them: [open/short/0..7, jammed/short/0..7]; none: each instance has its own",
        status="definition",
    )
    plugins: tuple[str, ...] = setting(
        (), "modules that register parts of your own: plugins=[my_module]; imported because you name them", status="run"
    )
    logger: str = setting(
        "none",
        "who is told of every generation while the run goes on; no result depends on it",
        status="run",
        part="logger",
    )
    run_dir: str | None = setting(None, "run folder; null names one under runs/ by date and settings", status="run")

    def cross_check(self) -> None:
        for name, kind in SECTIONS.items():
            if not isinstance(getattr(self, name), kind):
                raise refuse(name, getattr(self, name), f"a {kind.__name__}")
        plugins.check_named(self.plugins, plugins.SETTING)
        self._check_worlds()
        world, net = self.world, self.radio.network_range
        if world.jammer and world.file is None and net >= world.distance / 2:
            raise InputError(
                f"world.distance={world.distance:g}: no place for the jammer: accepted is more than twice "
                f"the network range of {net:.4g} m"
            )
        room = START_DISC_SHARE * (1 + 2 * world.start_radius / self.swarm.clearance) ** 2
        if self.swarm.agents > room and world.file is None:
            raise InputError(
                f"swarm.agents={self.swarm.agents}: no place for the agents: accepted is at most {int(room)} with "
                f"world.start_radius={world.start_radius:g} and swarm.clearance={self.swarm.clearance:g}"
            )

    def _check_worlds(self) -> None:
        kinds = kinds_of(self.worlds)
        if kinds and self.world.file is not None:
            raise InputError("worlds: not together with world=FILE; accepted is one of the two")
        for kind in kinds:
            kind.settings(self)  # refuses a world with no place for its jammer or its agents


SECTIONS: dict[str, type[Section]] = {
    "world": World,
    "radio": Radio,
    "jammers": Jammers,
    "swarm": Swarm,
    "learning": Learning,
    "rules": Rules,
    "task": Task,
    "search": Search,
    "knowledge": Knowledge,
    "compute": Compute,
    "checkpoint": Checkpoint,
}
