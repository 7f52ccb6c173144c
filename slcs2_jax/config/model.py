"""The model's settings: world, agents, learning and rules (docs/model.md), with reasons and limits.

Statuses are explained in `field.STATUS_MEANING`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from slcs2_jax.config.conf import choices
from slcs2_jax.config.errors import refuse, show
from slcs2_jax.config.field import LEAST, Section, setting
from slcs2_jax.config.radio import CALIBRATED
from slcs2_jax.config.world_text import read_world

MOST_BUILDINGS = 6_000  # of a world: the paper's have at most 100; of more, a step takes seconds

# What environment= and range= of the command line set in a world.
ENVIRONMENTS = choices("environment", ("open", "jammed", "urban", "urban_jammed"))
RANGES = choices("range", ("short", "long"))


@dataclass(frozen=True)
class World(Section):
    """Source, sink, buildings, jammer and start positions (docs/model.md)."""

    SECTION: ClassVar[str] = "world"

    environment: str = setting(
        "open",
        "environment type",
        name="environment",
        status="paper",
        options=tuple(ENVIRONMENTS),
    )
    range: str = setting(
        "short", "distance class: short 600 m, long 1000 m", name="range", status="paper", options=tuple(RANGES)
    )
    buildings: bool = setting(False, "are there buildings; set by environment", status="paper")
    jammer: bool = setting(False, "is there a jammer; set by environment", status="paper")
    distance: float = setting(
        600.0, "distance from source to sink; set by range", unit="m", status="paper", low=LEAST, high=1e6
    )
    time_limit: int = setting(
        20_000, "T, length of an episode; set by range", unit="steps", status="paper", low=1, high=10**7
    )
    strip_half_width: float = setting(
        100.0,
        "buildings and jammer lie this far to either side of the line from source to sink",
        unit="m",
        status="calibrated",
        reason="with 50 m few agents get through, and the paper finds open and urban alike",
        low=0,
        high=1e6,
    )
    start_radius: float = setting(
        50.0,
        "agents start in a disc of this radius around the source",
        unit="m",
        reason="close enough to hear the source",
        low=LEAST,
        high=1e6,
    )
    building_spacing: float = setting(
        10.0,
        "the number of buildings is uniform on 1..distance/spacing",
        unit="m",
        status="paper",
        low=LEAST,
        high=1e6,
    )
    building_min: float = setting(
        10.0, "smallest length and width of a building", unit="m", status="paper", low=LEAST, high=1e4
    )
    building_max: float = setting(
        30.0, "greatest length and width of a building", unit="m", status="paper", low=LEAST, high=1e4
    )
    wall_probability: float = setting(
        0.5, "chance of each of a building's six walls to be present", status="paper", low=0, high=1
    )
    wall_thickness: float = setting(1.0, "thickness of a wall", unit="m", status="paper", low=LEAST, high=10)
    scenario: str = setting(
        "strip", "what makes the world of a seed; strip is the paper's worlds", status="definition", part="scenario"
    )
    file: str | None = setting(
        None, "a world from a YAML file in place of one made from the seed; typed as world=PATH", status="definition"
    )
    content: str | None = setting(None, "the text of world.file, which is read once and kept", status="definition")

    @classmethod
    def preset(cls, environment: str = "open", range: str = "short") -> World:
        """The paper's world of a type and range, as the command line's environment= and range= make it."""
        if environment not in tuple(ENVIRONMENTS):  # of any type: a list cannot be looked up
            raise refuse("environment", environment, "one of " + ", ".join(ENVIRONMENTS))
        if range not in tuple(RANGES):
            raise refuse("range", range, "one of " + ", ".join(RANGES))
        return cls(**ENVIRONMENTS[environment], **RANGES[range])

    @classmethod
    def from_file(cls, path: str | Path) -> World:
        """The world that a file describes; see `world.world_file` for what it may say. Raises InputError naming it."""
        return cls(file=str(path), content=read_world(path))

    def cross_check(self) -> None:
        if (self.file is None) != (self.content is None):
            raise refuse("world.file", self.file, "the path of a file that is read when it is given: World.from_file")
        for name, value in ENVIRONMENTS[self.environment].items():
            if getattr(self, name) != value:
                raise refuse(f"world.{name}", getattr(self, name), f"{show(value)} with environment={self.environment}")
        if self.building_min > self.building_max:
            raise refuse(
                "world.building_min", self.building_min, f"a number up to world.building_max={self.building_max:g}"
            )
        if self.buildings and self.distance > MOST_BUILDINGS * self.building_spacing:
            raise refuse(
                "world.building_spacing",
                self.building_spacing,
                f"a number from {self.distance / MOST_BUILDINGS:g} with world.distance={self.distance:g}, for at most "
                f"{MOST_BUILDINGS:,} buildings",
            )
        if self.buildings and self.distance < self.building_spacing:
            raise refuse(
                "world.building_spacing",
                self.building_spacing,
                f"a number up to world.distance={self.distance:g}, so that one building can exist",
            )


@dataclass(frozen=True)
class Swarm(Section):
    """The agents' bodies, senses and load (docs/model.md)."""

    SECTION: ClassVar[str] = "swarm"

    agents: int = setting(12, "number of agents", status="calibrated", reason=CALIBRATED, low=2, high=64)
    packets: int = setting(
        150,
        "p, packets waiting at the source",
        status="calibrated",
        reason="of the values tried in fresh worlds the one that fits the paper's figures best",
        low=1,
        high=10**6,
    )
    speed: float = setting(
        2.0,
        "length of one step of motion",
        unit="m/step",
        status="calibrated",
        reason=CALIBRATED,
        low=LEAST,
        high=1e3,
    )
    clearance: float = setting(
        2.0,
        "least distance kept from walls and other agents",
        unit="m",
        reason="about one step of motion",
        low=LEAST,
        high=1e3,
    )
    lidar_range: float = setting(
        10.0,
        "how far an obstacle is seen",
        unit="m",
        reason="a small lidar; a few steps ahead",
        low=LEAST,
        high=1e4,
    )
    sharing_period: int = setting(
        10,
        "steps between exchanges of knowledge with neighbours",
        unit="steps",
        reason="hardly matters",
        low=1,
        high=10**7,
    )
    distance_threshold: float = setting(
        50.0,
        "d_th, the fixed distance that rules compare with",
        unit="m",
        reason="about a third of the network range",
        low=LEAST,
        high=1e6,
    )
    tolerance: float = setting(
        0.02,
        "equality tolerance relative to the right operand; at least one step of motion",
        reason="= on real numbers never holds without one",
        low=0,
        high=1,
    )
    sink_error: float = setting(
        0.0,
        "sigma of the error of the sink's known position, per axis",
        unit="m",
        reason="none unless studied",
        low=0,
        high=1e6,
    )
    failure_rate: float = setting(
        0.0, "chance of each agent to fail in a step; 0 is never", status="definition", low=0, high=1
    )
    failures_at: tuple[int, ...] = setting(
        (), "steps in which a share of the agents fails", unit="steps", status="definition", most=100, distinct=True,
        low=0, high=10**7,
    )  # fmt: skip
    failure_share: float = setting(
        0.25, "share of the agents that fails in each of failures_at", status="definition", low=0, high=1
    )
    recovery_steps: float | None = setting(
        None, "mean time until a failed agent works again; null: never", unit="steps", status="definition",
        low=1, high=1e7,
    )  # fmt: skip
    failure_keeps_packet: bool = setting(
        False, "does a failing agent keep the packet it holds; off: the packet is lost", status="definition"
    )


@dataclass(frozen=True)
class Learning(Section):
    """Choice of a rule and learning of its quality and strength (docs/model.md)."""

    SECTION: ClassVar[str] = "learning"

    alpha_grasp: float = setting(
        0.2, "width of the restricted candidate list; 0 is greedy, 1 random", reason="mostly greedy", low=0, high=1
    )
    alpha_q: float = setting(0.15, "learning rate of quality and error", reason="after XCS", low=0, high=1)
    alpha_q_final: float | None = setting(
        None,
        "learning rate at the time limit, reached linearly; null keeps alpha_q",
        reason="a constant rate unless studied",
        low=0,
        high=1,
    )
    beta_q: float = setting(
        0.71, "discount of the next step's best quality", reason="after XCS", low=0, high=1, high_open=True
    )
    trace_decay: float = setting(
        0.8,
        "lambda, decay of strength credit per step back",
        reason="lambda^bp_max is about 0.01, as the paper asks",
        low=0,
        high=1,
    )
    bp_max: int = setting(
        20,
        "how many steps back strength is credited",
        unit="steps",
        reason="lambda^bp_max is about 0.01, as the paper asks",
        low=0,
        high=24,
    )
    initial_quality: float = setting(
        0.0, "q of every rule at the start of an episode; above 0 is optimism", status="paper", low=-1e3, high=1e3
    )
    cost_move: float = setting(0.10, "C_a of a move", reason="small beside one step's progress", low=0, high=1e6)
    cost_communicate: float = setting(
        0.05, "C_a of a send or collect", reason="small beside one step's progress", low=0, high=1e6
    )


@dataclass(frozen=True)
class Task(Section):
    """When an episode is over, what it scores, and what a step is worth."""

    SECTION: ClassVar[str] = "task"

    name: str = setting("delivery", "when an episode is over, and what it scores", status="paper", part="task")
    reward: str = setting("progress", "what a step is worth to each agent", status="paper", part="reward")


@dataclass(frozen=True)
class Rules(Section):
    """Rule-sets and the grammar that makes them (docs/model.md)."""

    SECTION: ClassVar[str] = "rules"

    grammar: str = setting(
        "main", "main, channel, power, both, or the path of a BNF file", name="grammar", status="paper"
    )
    rules: int = setting(100, "rules per agent", status="paper", low=1, high=1000)
    codons: int = setting(40, "codons (0-255) per rule", reason="enough for the longest conditions", low=1, high=1024)
    distinct: bool = setting(
        False,
        "random rules are drawn until they can hold, and none is twice in an agent's rule-set",
        status="definition",
    )
    max_clauses: int = setting(
        8, "most clauses in a condition", reason="longer conditions hardly ever hold", low=1, high=64
    )
    single_option_consumes: bool = setting(
        False, "does a production with one option consume a codon", reason="the literature holds both conventions"
    )
