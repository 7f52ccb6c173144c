"""A saved solution: its rules, what they had learnt, and what it was made with, in one .npz file without pickles.

[n, R] = agents, rules. Rules stand in the file in words, each once, so that they mean the same whatever numbers clauses
and actions have in a later version, or beside other plug-ins.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError, Settings, plugins, settings_from, settings_to_dict
from slcs2_jax.config.arguments import path_of
from slcs2_jax.config.door import present, telling_damage
from slcs2_jax.config.field import refuse, show
from slcs2_jax.config.registry import any_name
from slcs2_jax.grammar import RuleSets, parse_rule_text, rule_from_mask
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.results.archive import Limits, check_arrays, read_archive, write_archive
from slcs2_jax.results.files import storing, write_text

FORMAT = "slcs2_jax solution 3"

_RULE = {"rule": np.int32}  # which of the texts each rule is
_LEARNT = {"quality": np.float32, "strength": np.float32, "error": np.float32, "usage": np.int32}
_ORIGIN = {"origin_kind": np.uint8, "origin_generation": np.int32, "origin_agent": np.int8}
_NO_ORIGIN = {"origin_kind": 0, "origin_generation": 0, "origin_agent": -1}
_PER_RULE: dict[str, Any] = _LEARNT | _ORIGIN
_OTHER: dict[str, Any] = _PER_RULE | {"contribution": np.float32}
_ABOUT: dict[str, type] = {
    "instance_seed": int,
    "generation": int,
    "fitness": float,
    "deployments": int,
    "grammar_text": str,
    "settings": dict,
    "rules": list,
}
_EXTRAS = {"reflex": np.bool_, "initial_quality": np.float32}  # of rules, in the file if the rules have them
_MOST_AGENTS, _MOST_RULES = 64, 1000
SOLUTIONS = "solutions"  # the folder of them in that of a run, which is no link
# Bytes of a rule's figures; and of the texts of 64 000 rules, each another one, of some 25 clauses
_LIMITS = Limits(entries=32, size=64 * _MOST_AGENTS * _MOST_RULES + 2**16, about=2**26)


@dataclass(frozen=True, eq=False, kw_only=True)
class SavedSolution:
    """One solution with its means over the deployments that evaluated it.

    Attributes:
        rules: of n agents with R rules each, with their reflexes and the quality they begin with if they have any.
        quality, strength, error: float32[n, R], q, zeta, epsilon at the end.
        usage: int32[n, R], tau.
        contribution: float32[n], delivered packets that the agent had held.
        settings: of the run it evolved in; run folder, device and saving are left at their defaults in a saved file.
        grammar_text: its grammar's BNF, so that a user's own grammar need not be found again.
        instance_seed, generation: which instance's search made it, and when.
        fitness: mean over `deployments`.
        origin_kind: uint8[n, R], how a rule came to the agent: 0 in the first solution, 1 random in a later one, 2
            copied from another agent; origin_generation: int32[n, R], when; origin_agent: int8[n, R], from which agent,
            -1 if it was not copied. Left out: all rules are of the first solution.
    """

    rules: RuleSets
    quality: NDArray[np.float32]
    strength: NDArray[np.float32]
    error: NDArray[np.float32]
    usage: NDArray[np.int32]
    contribution: NDArray[np.float32]
    settings: Settings
    grammar_text: str
    instance_seed: int
    generation: int
    fitness: float
    deployments: int
    origin_kind: NDArray[np.uint8] | None = None
    origin_generation: NDArray[np.int32] | None = None
    origin_agent: NDArray[np.int8] | None = None

    def __post_init__(self) -> None:
        shape = self.rules.action.shape
        for name, value in _NO_ORIGIN.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.full(shape, value, _ORIGIN[name]))
        for name, dtype in _OTHER.items():
            array = np.asarray(getattr(self, name)).astype(dtype, casting="same_kind")
            expected = shape[:1] if name == "contribution" else shape
            if array.shape != expected:
                raise InputError(f"{name}: shape {list(array.shape)}; accepted is {list(expected)}")
            if not np.isfinite(array).all():
                raise InputError(f"{name}: a value is not finite; accepted are finite numbers")
            if name in ("error", "usage", "contribution", "origin_generation") and (array < 0).any():
                raise InputError(f"{name}: a value is below 0; accepted are numbers from 0")
            object.__setattr__(self, name, array)
        self._check_origin()
        if not np.isfinite(self.fitness) or not -1 <= self.fitness <= 1:
            raise InputError(f"fitness={self.fitness}: accepted is a number from -1 to 1")
        if self.deployments < 1 or self.generation < 0 or self.instance_seed < 0:
            raise InputError("deployments, generation, instance_seed: accepted are whole numbers from 1, 0 and 0")

    def _check_origin(self) -> None:
        kind, agent = np.asarray(self.origin_kind), np.asarray(self.origin_agent)
        if (kind > 2).any() or ((agent >= 0) != (kind == 2)).any() or (agent < -1).any() or (agent >= len(kind)).any():
            raise InputError("origin: accepted are kinds 0 to 2, and an agent of the swarm where the kind is 2")

    @property
    def agents(self) -> int:
        """n, number of agents."""
        return self.rules.action.shape[0]

    def check_fits(self, settings: Settings) -> None:
        """Raise InputError unless these settings are for as many agents with as many rules as it has."""
        sizes = ("swarm.agents", settings.swarm.agents), ("rules.rules", settings.rules.rules)
        for (name, value), own in zip(sizes, self.rules.action.shape, strict=True):
            if value != own:
                raise refuse(name, value, f"{own}, as the solution has it")

    def forgetful(self) -> SavedSolution:
        """The same solution without the quality that its rules inherited: they begin as those of random rules do."""
        return replace(self, rules=replace(self.rules, quality=None))

    def save(self, path: Path, *, inside: Path | None = None) -> None:
        """Write the file whole or not at all; `inside` as in `results.files`. Raises StorageError."""
        about = {
            "instance_seed": int(self.instance_seed),
            "generation": int(self.generation),
            "fitness": float(self.fitness),
            "deployments": int(self.deployments),
            "grammar_text": self.grammar_text,
            "settings": settings_to_dict(self.settings),
            **plugins.recorded(self.settings.plugins),
        }
        arrays = {name: getattr(self, name) for name in _OTHER}
        about["rules"], arrays["rule"] = _in_words(self.rules)
        arrays |= {name: array for name, array in _extras_of(self.rules).items() if array is not None}
        write_archive(path, FORMAT, arrays, about, inside=inside)

    def text(self) -> str:
        """Every agent's rules as a person reads them, the strongest first, with q, zeta, eps and tau."""
        lines = [
            f"# fitness {self.fitness:.4f} over {self.deployments} deployment(s); generation {self.generation}, "
            f"seed {self.instance_seed}, grammar {self.settings.rules.grammar}",
        ]
        for agent in range(self.agents):
            lines += ["", f"agent {agent}   contribution {self.contribution[agent]:.1f}"]
            lines.append(f"{'q':>9} {'zeta':>9} {'eps':>9} {'tau':>7}  rule")
            for rule in np.argsort(-self.strength[agent], kind="stable"):
                q, zeta, eps = (array[agent, rule] for array in (self.quality, self.strength, self.error))
                tau = self.usage[agent, rule]
                text = reflex_mark(self.rules, agent, int(rule)) + _rule_text(self.rules, agent, rule)
                lines.append(f"{q:9.3f} {zeta:9.4f} {eps:9.3f} {tau:7d}  {text}")
        return "\n".join(lines) + "\n"

    def save_text(self, path: Path, *, inside: Path | None = None) -> None:
        """Write `text()` whole or not at all."""
        write_text(path, self.text(), inside=inside)


def reflex_mark(rules: RuleSets, agent: int, rule: int) -> str:
    """What stands before a rule's text: `reflex: ` if it acts before any choice."""
    return "reflex: " if rules.reflex is not None and rules.reflex[agent, rule] else ""


def _extras_of(rules: RuleSets) -> dict[str, Any]:
    """Reflexes and initial quality by their names in the file; None where there are none."""
    return {"reflex": rules.reflex, "initial_quality": rules.quality}


def _rule_text(rules: RuleSets, agent: int, rule: int) -> str:
    return _text(rules.mask[agent, rule].tobytes(), int(rules.action[agent, rule]), rules.vocabulary)


@functools.lru_cache(maxsize=2**13)  # some 2 MB; the members of a collection have most of their rules in common
def _text(mask: bytes, action: int, vocabulary: Vocabulary) -> str:
    return rule_from_mask(np.frombuffer(mask, np.uint32), action, vocabulary).text()


def _in_words(rules: RuleSets) -> tuple[list[str], NDArray[np.int32]]:
    """The different rules in words, and which of them each rule is: int32[n, R]."""
    places: dict[str, int] = {}
    which = [
        places.setdefault(_rule_text(rules, agent, rule), len(places)) for agent, rule in np.ndindex(rules.action.shape)
    ]
    return list(places), np.array(which, np.int32).reshape(rules.action.shape)


def _from_words(
    texts: list[Any], which: NDArray[np.int32], channels: tuple[int, ...], extras: dict[str, Any]
) -> RuleSets:
    """The rules that `_in_words` was given, by the numbers that clauses and actions have now. Raises InputError."""
    vocabulary = Vocabulary.current(channels)
    if len(texts) > which.size or not all(isinstance(text, str) for text in texts):
        raise InputError("its rules are not those of a solution")
    if which.min() < 0 or which.max() >= len(texts):
        raise InputError("its rules are not those of a solution")
    known = [parse_rule_text(text, vocabulary) for text in texts]
    mask, action = np.array([rule.mask() for rule in known]), np.array([rule.action for rule in known], np.uint8)
    begun = {"reflex": extras.get("reflex"), "quality": extras.get("initial_quality")}
    return RuleSets(mask[which], action[which], vocabulary, **begun)


def load_solution(path: str | Path) -> SavedSolution:
    """Read a saved solution.

    Raises InputError naming the file if it is none, damaged, or holds impossible values; StorageError.
    """
    file = path_of("solution", path)
    label = f"solution={file}"
    if not present(file):
        raise InputError(f"{label}: no such file; accepted is a solution saved by slcs2, RUN/solutions/*.npz")
    inside = file.parent.parent if file.parent.name == SOLUTIONS else None
    try:
        with storing(file, "read"):
            entries, about = read_archive(file, FORMAT, _LIMITS, inside=inside)
        with telling_damage("impossible values"):
            return _from_entries(entries, about)
    except plugins.PluginError as error:
        raise plugins.PluginError(f"{label}: {error}") from None
    except InputError as error:
        raise InputError(f"{label}: not a solution saved by slcs2 ({error})") from None


def _from_entries(entries: dict[str, NDArray[Any]], about: dict[str, Any]) -> SavedSolution:
    shape = entries["rule"].shape if "rule" in entries else (0, 0)
    if len(shape) != 2 or not 2 <= shape[0] <= _MOST_AGENTS or not 1 <= shape[1] <= _MOST_RULES:
        raise InputError(
            f"rule has shape {list(shape)}; accepted are 2-{_MOST_AGENTS} agents and 1-{_MOST_RULES} rules"
        )
    expected: dict[str, Any] = {name: (dtype, shape) for name, dtype in (_PER_RULE | _RULE).items()}
    expected["contribution"] = np.float32, shape[:1]
    extras = {name: entries[name] for name in _EXTRAS if name in entries}
    check_arrays(entries, expected | {name: (_EXTRAS[name], shape) for name in extras})
    with_plugins = {plugins.SETTING: about.pop(plugins.SETTING)} if plugins.SETTING in about else {}
    if set(about) != set(_ABOUT):
        raise InputError("its description is not that of a solution")
    for name, kind in _ABOUT.items():
        if not isinstance(about[name], kind) or isinstance(about[name], bool):
            raise InputError(f"{name}={show(repr(about[name]))} has the wrong type")
    plugins.check_same(with_plugins, "plugins")
    with any_name():
        settings = settings_from(about.pop("settings"))
    if (settings.swarm.agents, settings.rules.rules) != shape:
        raise InputError(f"{list(shape)} agents and rules, its settings say otherwise")
    arrays: dict[str, Any] = {name: entries[name] for name in _OTHER}
    rules = _from_words(about.pop("rules"), entries["rule"], settings.radio.channels, extras)
    return SavedSolution(rules=rules, settings=settings, **arrays, **about)
