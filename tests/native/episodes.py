"""What the tests of the native chunk play: episodes of any cell and size, and random states."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from importlib import resources
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax import episode as episodes
from slcs2_jax.config import Learning, Radio, Settings, Swarm, World
from slcs2_jax.episode import Episode, Parameters
from slcs2_jax.grammar import Grammar, load_grammar, random_rules
from slcs2_jax.grammar.grammar import parse_grammar
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import CHANNELS, Vocabulary
from slcs2_jax.native import advance as native
from slcs2_jax.native.arrays import EMISSIONS, MOTIONS
from slcs2_jax.policy.policy import Policy
from slcs2_jax.policy.rules import Rules
from slcs2_jax.world.arena import stack
from slcs2_jax.world.layout import Jammer
from slcs2_jax.world.scenario import make_scenario

ENVIRONMENTS = ("open", "jammed", "urban", "urban_jammed")
GRAMMARS = ("main", "channel", "power", "both")
RULES, BATCH = 100, 16
CAPACITY = (112, 112)


def make(
    environment: str,
    grammar_name: str,
    *,
    agents: int = 12,
    rules: int = RULES,
    seed: int = 0,
    batch: int = BATCH,
    range_: str = "short",
    policy: Policy | None = None,
    time_limit: int | None = None,
    learning: dict[str, Any] | None = None,
    radio: dict[str, Any] | None = None,
    channels: tuple[int, ...] = CHANNELS,
    jammers: Callable[[np.random.Generator], tuple[Jammer, ...]] | None = None,
    **swarm: Any,
) -> tuple[Episode, Parameters]:
    """A batch of episodes as deployed, with random rules in as many worlds.

    With `channels` other than the paper's the grammar is "both" over these; `jammers` draws those of a world.
    """
    settings = Settings(
        world=World.preset(environment, range_),
        swarm=Swarm(agents=agents, **swarm),
        learning=Learning(**learning or {}),
        radio=Radio(**{"channels": channels, **(radio or {})}),
    )
    scenarios: list[Any] = []
    for k in range(1000):
        scenario = make_scenario(settings, 1000 * seed + k)
        if max(len(scenario.vertical), len(scenario.horizontal)) <= CAPACITY[0]:
            limit = time_limit or scenario.time_limit
            scenarios.append(dataclasses.replace(scenario, time_limit=limit))
        if len(scenarios) == batch:
            break
    grammar = load_grammar(grammar_name) if channels == CHANNELS else with_channels(channels)
    rng = np.random.default_rng(seed)
    if jammers is not None:
        scenarios = [dataclasses.replace(scenario, jammers=jammers(rng)) for scenario in scenarios]
    mask, action = random_rules(grammar, batch * agents * rules, rng)
    given = Rules(
        mask=np.ascontiguousarray(mask.reshape(batch, agents, rules, -1).transpose(3, 2, 1, 0)),
        action=np.ascontiguousarray(action.reshape(batch, agents, rules).transpose(2, 1, 0)),
    )
    arena = stack(scenarios, [grammar.channels_used] * batch, capacity=CAPACITY, width=len(channels))
    key = rng.integers(0, 2**32, (2, batch), dtype=np.uint32)
    parameters = Parameters.of(settings, policy, Language(grammar.vocabulary, grammar.vocabulary.words))
    arena, given, keys = jax.tree.map(jnp.asarray, (arena, given, key))
    return native.begin(arena, given, keys, parameters), parameters


def with_channels(channels: tuple[int, ...]) -> Grammar:
    """The grammar "both" over these."""
    text = (resources.files("slcs2_jax.grammar") / "bnf" / "both.bnf").read_text(encoding="utf-8")
    text = text.replace("1 | 6 | 11", " | ".join(map(str, channels)))
    return parse_grammar(text, name="both", vocabulary=Vocabulary.current(channels))


def some_jammers(rng: np.random.Generator) -> tuple[Jammer, ...]:
    """None to five of every kind, near the way from the source."""
    made = []
    for _ in range(rng.integers(0, 6)):
        route = rng.uniform((0, -80), (300, 80), (1 + rng.integers(1, 4), 2)).astype(np.float32)
        motion = str(rng.choice(MOTIONS))
        made.append(
            Jammer(
                place=route[0],
                emission=str(rng.choice(EMISSIONS)),
                motion=motion,
                power_db=float(rng.choice([-20.0, -6.0, 0.0])),
                speed=float(rng.uniform(0.5, 5)),
                duty=float(rng.uniform(0, 1)),
                dwell=int(rng.integers(1, 12)),
                route=route[1:] if motion == "patrol" else route[:0],
            )
        )
    return tuple(made)


@functools.cache
def jitted(function: Any) -> Any:
    """A function of an episode, parameters and a number, compiled."""
    return jax.jit(function, static_argnums=2)


def by_native(episode: Episode, parameters: Parameters, periods: int) -> Episode:
    """Advance natively."""
    return jitted(native.advance)(episode, parameters, periods)


def by_xla(episode: Episode, parameters: Parameters, periods: int) -> Episode:
    """Advance by the definition."""
    return jitted(episodes.advance)(episode, parameters, periods)


def leaves(tree: Any) -> dict[str, np.ndarray]:
    """All arrays by name, on the host."""
    found = jax.tree_util.tree_leaves_with_path(tree)
    return {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in found}


def assert_same_bytes(found: Any, expected: Any) -> None:
    """Every bit of two trees is the same."""
    expected = leaves(expected)
    for name, leaf in leaves(found).items():
        assert leaf.tobytes() == expected[name].tobytes(), name
