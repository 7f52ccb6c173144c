"""Files that a command is given by name: a policy, a decision list, a world, a grammar."""

from __future__ import annotations

from pathlib import Path

import jax.numpy as jnp
import numpy as np

from slcs2_jax.config import Settings
from slcs2_jax.config.registry import KINDS, register
from slcs2_jax.grammar import Grammar
from slcs2_jax.policy.policy import Policy
from slcs2_jax.results.policy_file import save_policy
from slcs2_jax.world.scenario import make_scenario
from slcs2_jax.world.world_file import scenario_text

FOLDER = "given"  # in the run folder, so that what is done to its files can be done to these
POLICY, DECISIONS, WORLD, GRAMMAR = (f"{FOLDER}/{name}" for name in ("walk.npz", "list.txt", "world.yaml", "mine.bnf"))
FILES = (POLICY, DECISIONS, WORLD, GRAMMAR)
NAME = "campaign_walk"  # of the policy that the file names


class Walk(Policy):
    """The first action, always."""

    def initial_memory(self, parameters, agents, learning):  # type: ignore[no-untyped-def]
        return ()

    def decide(self, memory, parameters, seen, clock, learning):  # type: ignore[no-untyped-def]
        return memory, jnp.zeros(seen.view.x.shape, jnp.int32) + parameters["action"][0]


def register_policy() -> None:
    """As a plug-in would."""
    if NAME not in KINDS["policy"].own():
        register("policy", NAME)(Walk)


def write_given(run: Path, settings: Settings) -> None:
    """Good ones of all these files."""
    (run / FOLDER).mkdir()
    save_policy(run / POLICY, NAME, {"action": np.zeros(1, np.int32)})
    (run / DECISIONS).write_text("packet held => move toward sink\nno packet held => move toward source\n")
    (run / WORLD).write_text(scenario_text(make_scenario(settings, settings.seed)))
    (run / GRAMMAR).write_text(Grammar.of(settings).text)


def commands(run: Path, sizes: tuple[str, ...]) -> dict[str, list[str]]:
    """By file, the command that is given it."""
    evolve = ["evolve", "generations=1", "search.fresh_deployments=1", "swarm.agents=3", "swarm.packets=3", *sizes]
    few = ("swarm.agents=3", "instances=1", "compute.devices=1", "compute.chunk=20")
    return {
        POLICY: ["evaluate", f"policy={run / POLICY}", *sizes],
        DECISIONS: ["evaluate", f"policy={run / DECISIONS}", *sizes],
        WORLD: ["evaluate", "policy=designed", f"world={run / WORLD}", *few],
        GRAMMAR: [*evolve, f"grammar={run / GRAMMAR}", f"run_dir={run / 'evolved'}"],
    }
