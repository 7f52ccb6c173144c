"""A saved solution: its rules, what they had learnt, and what it was made with, in one .npz file without pickles.

[n, R] = agents, rules; W = 4 words of 32 clauses.
"""

from __future__ import annotations

import json
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.config import InputError, Settings, settings_from, settings_to_dict
from slcs2_jax.grammar import RuleSets
from slcs2_jax.results.files import write_text, write_whole

FORMAT = "slcs2_jax solution 1"

_ARRAYS: dict[str, type[np.generic]] = {
    "mask": np.uint32,
    "action": np.uint8,
    "quality": np.float32,
    "strength": np.float32,
    "error": np.float32,
    "usage": np.int32,
    "contribution": np.float32,
}
_TEXTS = ("format", "about")
_ABOUT: dict[str, type | tuple[type, ...]] = {
    "instance_seed": int,
    "generation": int,
    "fitness": float,
    "deployments": int,
    "grammar_text": str,
    "settings": dict,
}
_MOST_AGENTS, _MOST_RULES = 64, 1000


@dataclass(frozen=True, eq=False, kw_only=True)
class SavedSolution:
    """One solution with its means over the deployments that evaluated it.

    Attributes:
        rules: mask uint32[n, R, W] and action uint8[n, R].
        quality, strength, error: float32[n, R], q, zeta, epsilon at the end.
        usage: int32[n, R], tau.
        contribution: float32[n], delivered packets that the agent had held.
        settings: of the run it evolved in.
        grammar_text: its grammar's BNF, so that a user's own grammar need not be found again.
        instance_seed, generation: which instance's search made it, and when.
        fitness: mean over `deployments`.
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

    def __post_init__(self) -> None:
        shape = self.rules.action.shape
        for name in ("quality", "strength", "error", "usage", "contribution"):
            array = np.asarray(getattr(self, name)).astype(_ARRAYS[name], casting="same_kind")
            expected = shape[:1] if name == "contribution" else shape
            if array.shape != expected:
                raise InputError(f"{name}: shape {list(array.shape)}; accepted is {list(expected)}")
            if not np.isfinite(array).all():
                raise InputError(f"{name}: a value is not finite; accepted are finite numbers")
            if name in ("error", "usage", "contribution") and (array < 0).any():
                raise InputError(f"{name}: a value is below 0; accepted are numbers from 0")
            object.__setattr__(self, name, array)
        if not np.isfinite(self.fitness) or not -1 <= self.fitness <= 1:
            raise InputError(f"fitness={self.fitness}: accepted is a number from -1 to 1")
        if self.deployments < 1 or self.generation < 0 or self.instance_seed < 0:
            raise InputError("deployments, generation, instance_seed: accepted are whole numbers from 1, 0 and 0")

    @property
    def agents(self) -> int:
        """n, number of agents."""
        return self.rules.action.shape[0]

    def save(self, path: Path) -> None:
        """Write the file whole or not at all."""
        about = {
            "instance_seed": int(self.instance_seed),
            "generation": int(self.generation),
            "fitness": float(self.fitness),
            "deployments": int(self.deployments),
            "grammar_text": self.grammar_text,
            "settings": settings_to_dict(self.settings),
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS if name not in ("mask", "action")}
        arrays |= {"mask": self.rules.mask, "action": self.rules.action}
        entries: dict[str, Any] = arrays | {
            "format": np.array(FORMAT),
            "about": np.array(json.dumps(about, allow_nan=False)),
        }
        write_whole(path, lambda file: np.savez_compressed(file, **entries))

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
                lines.append(f"{q:9.3f} {zeta:9.4f} {eps:9.3f} {tau:7d}  {self.rules.text(agent, int(rule))}")
        return "\n".join(lines) + "\n"

    def save_text(self, path: Path) -> None:
        """Write `text()` whole or not at all."""
        write_text(path, self.text())


def load_solution(path: str | Path) -> SavedSolution:
    """Read a saved solution. Raises InputError naming the file if it is none, damaged, or holds impossible values."""
    file = Path(path)
    label = f"solution={file}"
    if not file.is_file():
        raise InputError(f"{label}: no such file; accepted is a solution saved by slcs2, RUN/solutions/*.npz")
    try:
        if not zipfile.is_zipfile(file):
            raise InputError("no .npz archive, or cut short")
        with file.open("rb") as raw, np.load(raw, allow_pickle=False) as stored:
            if not isinstance(stored, np.lib.npyio.NpzFile):
                raise InputError("not an .npz archive")
            if set(stored.files) != {*_ARRAYS, *_TEXTS}:
                raise InputError("its entries are not those of a solution")
            entries = {name: stored[name] for name in stored.files}
        return _from_entries(entries)
    except InputError as error:
        raise InputError(f"{label}: not a solution saved by slcs2 ({error})") from None
    except (OSError, EOFError, ValueError, KeyError, MemoryError, NotImplementedError, RecursionError,
            zipfile.BadZipFile, zlib.error) as error:  # fmt: skip
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{label}: cannot be read as a solution saved by slcs2 ({reason})") from None


def _from_entries(entries: dict[str, NDArray[Any]]) -> SavedSolution:
    for name in _TEXTS:
        if entries[name].dtype.kind != "U" or entries[name].shape != ():
            raise InputError(f"{name} is not a text")
    if str(entries["format"]) != FORMAT:
        raise InputError(f"format {str(entries['format'])[:40]!r}; accepted is {FORMAT!r}")
    for name, dtype in _ARRAYS.items():
        if entries[name].dtype != dtype:
            raise InputError(f"{name} is {entries[name].dtype}; accepted is {np.dtype(dtype)}")
    shape = entries["action"].shape
    if len(shape) != 2 or not 2 <= shape[0] <= _MOST_AGENTS or not 1 <= shape[1] <= _MOST_RULES:
        raise InputError(
            f"action has shape {list(shape)}; accepted are 2-{_MOST_AGENTS} agents and 1-{_MOST_RULES} rules"
        )
    about = json.loads(str(entries["about"]))
    if not isinstance(about, dict) or set(about) != set(_ABOUT):
        raise InputError("its description is not that of a solution")
    for name, kind in _ABOUT.items():
        if not isinstance(about[name], kind) or isinstance(about[name], bool):
            raise InputError(f"{name}={about[name]!r} has the wrong type")
    settings = settings_from(about.pop("settings"))
    if (settings.swarm.agents, settings.rules.rules) != shape:
        raise InputError(f"{list(shape)} agents and rules, its settings say otherwise")
    arrays: dict[str, Any] = {name: entries[name] for name in _ARRAYS if name not in ("mask", "action")}
    return SavedSolution(rules=RuleSets(entries["mask"], entries["action"]), settings=settings, **arrays, **about)
