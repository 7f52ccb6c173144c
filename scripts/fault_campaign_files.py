"""One of every kind of file beside those of runs, and how each is read: of policies, trainings, suites, transfers.

What a person writes by hand has no checksum: changed, it is another text, which is refused in a line or means what it
says. Whatever a program wrote is read as it was, or refused.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import fault_campaign_suite as suite
import jax
import numpy as np

from slcs2_jax.config import Rules, Settings, Swarm, World
from slcs2_jax.grammar import load_grammar, random_rules
from slcs2_jax.grammar.ruleset import RuleSets
from slcs2_jax.learning.training_folder import CHECKPOINT, CURVE, TrainingFolder
from slcs2_jax.policy.bound import load_bound
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.policy.trained_network import NAME, initial_parameters
from slcs2_jax.results import SavedSolution, load_solution
from slcs2_jax.results.documents import write_document
from slcs2_jax.results.policy_file import save_policy
from slcs2_jax.results.rows import append_rows
from slcs2_jax.running.transfer import known_deployments
from slcs2_jax.suite.entries import entry_named
from slcs2_jax.suite.measured import Measured, load
from slcs2_jax.suite.training import KIND, VERSION, read_record
from slcs2_jax.world.scenario import make_scenario
from slcs2_jax.world.world_file import scenario_text

CHANCE = np.random.default_rng(1)
SETTINGS = Settings(world=World(distance=120.0, time_limit=60), swarm=Swarm(agents=3), rules=Rules(rules=6))
IDENTITY = {"algorithm": "ippo", "seed": 1}
COUNTERS = {"env_steps": 3, "playing": [0, 1, 2]}
RESULT, DEPLOYMENTS = f"results/mine/{suite.WORLD}.npz", "deployments.jsonl"


def _plain(value: Any) -> Any:
    """In a form that can be compared."""
    if isinstance(value, RuleSets):
        return _plain({name: getattr(value, name) for name in ("mask", "action", "reflex", "quality")})
    if isinstance(value, Mapping):
        return {name: _plain(inner) for name, inner in value.items()}
    return (value.dtype, value.tobytes()) if isinstance(value, np.ndarray) else value


def _policy(path: Path) -> object:
    found, about = load_bound(path)
    return [_plain(leaf) for leaf in jax.tree.leaves(found.given)], about


def _training(path: Path) -> object:
    folder = TrainingFolder(path.parent, IDENTITY)
    found = folder.load(_tree(), COUNTERS)
    return found and (_plain(found[0]), found[1], folder.last(9))


def _result(path: Path) -> object:
    found = load(path.parents[2], path.parent.name, suite.small_suite().worlds[suite.WORLD])
    return found and _plain(vars(found))


def _world(path: Path) -> None:
    make_scenario(dataclasses.replace(SETTINGS, world=World.from_file(path)), 1)


def _entry(path: Path) -> None:
    entry = entry_named(str(path))
    if not entry.trained:
        entry.decision_list()


WRITTEN: dict[str, Callable[[Path], object]] = {
    "policy.npz": _policy,
    "solution.npz": lambda path: _plain(vars(load_solution(path))),
    "record.json": read_record,
    RESULT: _result,
    CHECKPOINT: _training,
    CURVE: _training,
    DEPLOYMENTS: known_deployments,
}
BY_HAND: dict[str, Callable[[Path], object]] = {
    "world.yaml": _world,
    "search.yaml": _entry,
    "network.yaml": _entry,
    "takes_part.txt": _entry,
    "list.txt": lambda path: load_decision_list(path) and None,
}
READERS = WRITTEN | BY_HAND


def _tree() -> dict[str, np.ndarray]:
    return {"weights": np.arange(40, dtype=np.float32).reshape(8, 5), "steps": np.arange(3, dtype=np.int32)}


def write_files(folder: Path) -> None:
    """Good ones of all."""
    folder.mkdir(parents=True, exist_ok=True)
    grammar = load_grammar("main")
    network = initial_parameters(grammar, CHANCE, hidden=(4,))
    save_policy(folder / "policy.npz", NAME, network, {"env_steps": 7, "episodes": 2})
    _solution().save(folder / "solution.npz")
    counts = dict.fromkeys(("budget", "episodes", "env_steps", "validation_episodes", "validation_env_steps"), 5)
    said = {"digest": "0" * 64, "sha256": "1" * 64, "chosen": 0, "validation": [[0.5, 0.25]]}
    write_document(folder / "record.json", KIND, VERSION, counts | said)
    _measured().save(folder)
    training = TrainingFolder(folder, IDENTITY)
    for number in range(3):
        training.note({"env_steps": 1 + number, "loss": 0.5 / (1 + number)})
    training.save(_tree(), COUNTERS)
    append_rows(folder / DEPLOYMENTS, [{"job": f"{number:032x}", "fitness": [0.1, -0.5]} for number in range(4)])
    (folder / "world.yaml").write_text(scenario_text(make_scenario(SETTINGS, 1)))
    for name, entry in (("search.yaml", suite.RACED), ("network.yaml", suite.IPPO), ("takes_part.txt", suite.LIST)):
        (folder / name).write_text(suite.TEXTS[entry])
    (folder / "list.txt").write_text(suite.TEXTS[suite.LIST])


def _solution() -> SavedSolution:
    grammar, shape = load_grammar("both"), (3, 6)
    mask, action = random_rules(grammar, 18, CHANCE)
    reflex, quality = CHANCE.random(shape) < 0.5, CHANCE.random(shape, np.float32)
    figures = [CHANCE.random(shape, np.float32) for _ in range(3)]
    return SavedSolution(
        rules=RuleSets(mask.reshape(*shape, -1), action.reshape(shape), reflex=reflex, quality=quality),
        quality=figures[0],
        strength=figures[1],
        error=figures[2],
        usage=np.ones(shape, np.int32),
        contribution=np.ones(3, np.float32),
        settings=dataclasses.replace(SETTINGS, rules=Rules(rules=6, grammar="both")),
        grammar_text=grammar.text,
        instance_seed=4,
        generation=2,
        fitness=0.5,
        deployments=6,
    )


def _measured() -> Measured:
    world = suite.small_suite().worlds[suite.WORLD]
    counts = np.ones((1, 2, 3), np.int32)
    return Measured(
        version=world.version,
        world=world.name,
        sha256=world.sha256,
        entry="mine",
        title="Mine",
        field="yours",
        digest="0" * 64,
        split="test",
        seeds=np.array(world.seeds_of("test"), np.int64),
        delivered=counts,
        steps=9 * counts,
    )
