"""Parts of the model that are chosen by name: one registry for each kind, for this package's parts and for users'."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from slcs2_jax.config.errors import InputError, refuse, show

Part = TypeVar("Part")

LONGEST_NAME = LONGEST_SUMMARY = 80  # characters


class Registry:
    """The parts of one kind by name, in the order registered, this package's first.

    A part of this package is named by where it stands, `module:attribute`, and imported when it is first asked for, so
    that listing names starts nothing. A user's part is registered by the user's own code; nothing in a file can do so.
    """

    def __init__(self, kind: str, setting: str, meaning: str, built_in: Mapping[str, str] | None = None) -> None:
        """`kind` and `meaning` are for help; `setting` chooses a part by name and is named when that fails."""
        self.kind, self.setting, self.meaning = kind, setting, meaning
        self._built_in = dict(built_in or {})
        self._parts: dict[str, Any] = {}
        self._homes: dict[str, str] = {}  # of users' parts: the module that registered each

    def names(self) -> tuple[str, ...]:
        """All names, this package's first."""
        return (*self._built_in, *(name for name in self._parts if name not in self._built_in))

    def own(self) -> tuple[str, ...]:
        """The names of users' parts, in the order registered."""
        return tuple(self._homes)

    def home(self, name: str) -> str | None:
        """The module that registered a user's part; None for this package's."""
        return self._homes.get(name)

    def summary(self, name: str) -> str:
        """What a part's documentation says first; one of this package is not imported for it."""
        if name in self._parts or name not in self._built_in:
            text = inspect.getdoc(self.get(name))
        else:
            module, _, attribute = self._built_in[name].partition(":")
            text = _documentation(module, attribute)
        paragraph = " ".join((text or "").split("\n\n")[0].split())
        return re.split(r"(?<=[.]) ", paragraph)[0] if len(paragraph) > LONGEST_SUMMARY else paragraph

    def get(self, name: str) -> Any:
        """The part of this name. Raises InputError naming the setting and the names that exist."""
        if name not in self._parts:
            if name not in self._built_in:
                raise refuse(self.setting, name, f"one of {', '.join(self.names())}, or a name that plugins= brings")
            module, _, attribute = self._built_in[name].partition(":")
            self._parts[name] = getattr(importlib.import_module(module), attribute)
        return self._parts[name]

    def add(self, name: str, part: Any, home: str) -> None:
        """Take a user's part. One of the same module takes the place of its former self, as on a reload in a notebook.

        Raises InputError for a name that is no name, this package's, or another module's.
        """
        if not isinstance(name, str) or not 0 < len(name.strip()) <= LONGEST_NAME or not name.isprintable():
            raise InputError(
                f"register: {self.kind} {show(name)}: accepted is a name of 1 to {LONGEST_NAME} characters"
            )
        if name in self._built_in:
            raise InputError(f"register: {self.kind} {show(name)} is this package's; accepted is another name")
        if self._homes.get(name, home) != home:
            raise InputError(f"register: {self.kind} {show(name)} is that of the plug-in {self._homes[name]} already")
        self._parts[name], self._homes[name] = part, home

    def forget(self, name: str) -> None:
        """Drop a user's part; for tests and notebooks."""
        if self._homes.pop(name, None) is not None:
            del self._parts[name]


def _documentation(module: str, attribute: str) -> str | None:
    """The docstring of a class or function, read from its module's source."""
    found = importlib.util.find_spec(module)
    if found is None or found.origin is None:
        return None
    tree = ast.parse(Path(found.origin).read_text(encoding="utf-8"))
    documented = ast.ClassDef | ast.FunctionDef
    return next((ast.get_docstring(x) for x in tree.body if isinstance(x, documented) and x.name == attribute), None)


KINDS: dict[str, Registry] = {
    registry.kind: registry
    for registry in (
        Registry("clause", "grammar", "what a condition can say: words, and their truth for every agent"),
        Registry("action", "grammar", "what an agent can do: words, and their meaning"),
        Registry("move target", "grammar", "what a move can be toward, away from or around: a word, and a place"),
        Registry(
            "reward",
            "task.reward",
            "what a step is worth to each agent",
            {"progress": "slcs2_jax.swarm.reward:Progress"},
        ),
        Registry(
            "task",
            "task.name",
            "when an episode is over, and what it scores",
            {"delivery": "slcs2_jax.swarm.task:Delivery"},
        ),
        Registry(
            "propagation",
            "radio.propagation",
            "mean received power over distance and walls",
            {"log_distance": "slcs2_jax.world.propagation:LogDistance"},
        ),
        Registry(
            "fading",
            "radio.fading",
            "how received power varies from step to step",
            {
                "none": "slcs2_jax.world.fading:NoFading",
                "lognormal": "slcs2_jax.world.fading:LogNormal",
                "rayleigh": "slcs2_jax.world.fading:Rayleigh",
                "rician": "slcs2_jax.world.fading:Rician",
                "nakagami": "slcs2_jax.world.fading:Nakagami",
            },
        ),
        Registry(
            "emission",
            "jammers.emission",
            "when and on which channel a jammer transmits",
            {
                "reactive": "slcs2_jax.world.emission:reactive",
                "constant": "slcs2_jax.world.emission:constant",
                "random": "slcs2_jax.world.emission:random",
                "sweeping": "slcs2_jax.world.emission:sweeping",
            },
        ),
        Registry(
            "jammer motion",
            "jammers.motion",
            "how a jammer moves",
            {
                "fixed": "slcs2_jax.world.jammer_motion:fixed",
                "patrol": "slcs2_jax.world.jammer_motion:patrol",
                "pursue": "slcs2_jax.world.jammer_motion:pursue",
            },
        ),
        Registry(
            "scenario",
            "world.scenario",
            "makes the world of a seed",
            {"strip": "slcs2_jax.world.strip:make_strip"},
        ),
        Registry(
            "policy",
            "policy",
            "what an agent does with what it sees",
            {
                "classifier": "slcs2_jax.policy.classifier:Classifier",
                "decision_list": "slcs2_jax.policy.first_match:FirstMatch",
                "network": "slcs2_jax.policy.trained_network:TrainedNetwork",
            },
        ),
        Registry(
            "search",
            "search.name",
            "proposes solutions and learns from their evaluations",
            {
                "slcs2": "slcs2_jax.search.slcs2:Slcs2",
                "random": "slcs2_jax.search.random:RandomSearch",
                "informed": "slcs2_jax.search.informed:Informed",
                "starters": "slcs2_jax.search.starters:Starters",
            },
        ),
        Registry(
            "acceptance",
            "acceptance",
            "which evaluated solutions are explored further, and which next",
            {
                "domination": "slcs2_jax.search.collection:Collection",
                "ailta": "slcs2_jax.search.ailta:Ailta",
                "best": "slcs2_jax.search.population:Best",
                "map_elites": "slcs2_jax.search.map_elites:MapElites",
                "dominated_novelty": "slcs2_jax.search.dominated_novelty:DominatedNovelty",
            },
        ),
        Registry(
            "variation",
            "search.variation",
            "makes a new solution from an evaluated one",
            {
                "exchange": "slcs2_jax.search.offspring:Exchange",
                "random": "slcs2_jax.search.fresh:Fresh",
            },
        ),
        Registry(
            "parent",
            "search.parent",
            "which of the solutions under exploration is varied next",
            {
                "fewest": "slcs2_jax.search.parents:FewestExplorations",
                "uniform": "slcs2_jax.search.parents:Uniform",
                "tournament": "slcs2_jax.search.population:Tournament",
            },
        ),
        Registry(
            "logger",
            "logger",
            "who is told of every generation while a run goes on",
            {
                "none": "slcs2_jax.results.loggers:Nobody",
                "jsonl": "slcs2_jax.results.loggers:JsonLines",
                "tensorboard": "slcs2_jax.results.loggers:TensorBoard",
                "wandb": "slcs2_jax.results.loggers:WeightsAndBiases",
                "trackio": "slcs2_jax.results.loggers:Trackio",
            },
        ),
    )
}


_any_name: ContextVar[bool] = ContextVar("any_name", default=False)


@contextmanager
def any_name() -> Iterator[None]:
    """Within it settings may name parts that are not registered: those of a run that is only read. Using one fails."""
    before = _any_name.set(True)
    try:
        yield
    finally:
        _any_name.reset(before)


def may_be_named(kind: str, name: str) -> bool:
    """May a setting name this part of a kind?"""
    return name in KINDS[kind].names() or _any_name.get()


def register(kind: str, name: str) -> Callable[[Part], Part]:
    """A decorator that registers a part under a name: `@slcs2_jax.register("fading", "two_ray")`.

    Raises InputError for a kind that does not exist, or a name that is taken.
    """
    if kind not in KINDS:
        raise refuse("register", kind, "one of " + ", ".join(KINDS))

    def take(part: Part) -> Part:
        KINDS[kind].add(name, part, getattr(part, "__module__", "") or type(part).__module__)
        return part

    return take
