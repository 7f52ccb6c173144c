"""The environment: an episode to step from outside, by pure functions for `jit`, `vmap` and `scan`.

    env = slcs2_jax.make("open_short")
    observation, state = env.reset(key, env.params)
    observation, state, reward, terminated, truncated, info = env.step(key, state, action, env.params)

Worlds and physical parameters are values, not code: `env.params` can be stacked and mapped over, and compiles once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.config import InputError, Settings, World
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.field import refuse
from slcs2_jax.config.model import ENVIRONMENTS, RANGES
from slcs2_jax.config.schema import settings_from
from slcs2_jax.grammar import Grammar
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import NO_ACTION, WORD_BITS, Vocabulary
from slcs2_jax.swarm import knowledge
from slcs2_jax.swarm import step as swarm
from slcs2_jax.swarm.action_mask import action_mask
from slcs2_jax.swarm.failure import CHANGEABLE
from slcs2_jax.swarm.observation import Feature, Observation, feature_list, features
from slcs2_jax.swarm.state import State, SwarmParameters
from slcs2_jax.swarm.step import Physics
from slcs2_jax.swarm.task import Delivery
from slcs2_jax.swarm.view import View
from slcs2_jax.world.arena import Arena, stack, wall_capacity
from slcs2_jax.world.emitters import JammerRoom, has_room, jammer_room
from slcs2_jax.world.geometry import BLOCK
from slcs2_jax.world.radio import RadioParameters
from slcs2_jax.world.scenario import Scenario, check_scenario, make_scenario
from slcs2_jax.world.scenario_check import MOST_WALLS

CELLS = tuple(f"{kind}_{far}" for kind in ENVIRONMENTS for far in RANGES)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Params:
    """What an environment is run with: the world, and the physics in it. Every leaf may be mapped over."""

    arena: Arena
    physics: Physics


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class EnvState:
    """An episode under way: what its agents see now, without what `Params` hold."""

    seen: Observation

    @property
    def swarm(self) -> State:
        """Places, packets, knowledge: everything that changes."""
        return self.seen.view.state


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Seen:
    """What an environment's agents observe.

    Attributes:
        clauses: bool [n, K], the truth of every clause; `Env.clauses` says which.
        features: float32 [n, F], figures; `Env.features` says which, in what unit and on what scale.
        action_mask: bool [n, A], actions that could have an effect now.
    """

    clauses: jax.Array
    features: jax.Array
    action_mask: jax.Array


class Spaces(NamedTuple):
    """Sizes: agents n, clauses K, features F, actions A. The action of an agent is a whole number below A."""

    agents: int
    clauses: int
    features: int
    actions: int


class Env:
    """One world with its task. Sizes and code are fixed; everything else is in `params`."""

    def __init__(
        self,
        settings: Settings,
        scenario: Scenario | None = None,
        *,
        task: Delivery | None = None,
        walls: tuple[int, int] | None = None,
        jammers: JammerRoom | None = None,
    ) -> None:
        """An environment of these settings.

        Args:
            settings: radio, swarm, task and the grammar, which says what can be observed and done.
            scenario: the world; by default that of the settings' seed.
            task: when an episode is over, and what a step is worth; by default the one that the settings name.
            walls: room for vertical and horizontal walls, for worlds that are swapped in; by default the scenario's.
            jammers: room for jammers, `jammer_room` of all these worlds; by default the scenario's.

        Raises:
            InputError: an impossible setting, or a scenario that does not fit.
        """
        self.settings = of_kind("settings", settings, Settings)
        scenario = make_scenario(settings, settings.seed) if scenario is None else scenario
        check_scenario(of_kind("scenario", scenario, Scenario), settings)
        self._walls = wall_capacity([scenario]) if walls is None else _whole_blocks(walls)
        self._jammers = jammers or jammer_room([scenario])
        grammar = Grammar.of(settings)
        self._grammar = grammar
        self.vocabulary: Vocabulary = grammar.vocabulary
        self._channels = grammar.channels_used
        language = Language.of([grammar])
        physics = Physics.of(settings, language)
        self._physics = physics if task is None else dataclasses.replace(physics, task=of_kind("task", task, Delivery))
        self._period = settings.swarm.sharing_period
        self.params = Params(self.arena(scenario), self._physics)
        self._actions = np.array(grammar.actions, np.int32)

    # What there is.

    @property
    def agents(self) -> int:
        """n."""
        return self.settings.swarm.agents

    @property
    def spaces(self) -> Spaces:
        """Sizes of observations and actions."""
        return Spaces(self.agents, len(self._grammar.clauses), len(self.features), len(self._actions) + 1)

    @property
    def clauses(self) -> tuple[str, ...]:
        """The clauses that are observed, in words, in the order of `Seen.clauses`: those of the grammar."""
        return tuple(self.vocabulary.clause_text(k) for k in self._grammar.clauses)

    @property
    def features(self) -> tuple[Feature, ...]:
        """The entries of `Seen.features`."""
        return feature_list(1 + max(self._channels))

    @property
    def actions(self) -> tuple[str, ...]:
        """What each action is, in words: those of the grammar, and last to do nothing."""
        return (*(self.vocabulary.action_text(k) for k in self._grammar.actions), "do nothing")

    def arena(self, scenario: Scenario) -> Arena:
        """A world as this environment takes it, for `Params`. Raises InputError if it has more walls than there is room
        for, more jammers, or does not fit the settings."""
        check_scenario(of_kind("scenario", scenario, Scenario), self.settings)
        needed = wall_capacity([scenario])
        if needed[0] > self._walls[0] or needed[1] > self._walls[1]:
            raise InputError(f"walls={self._walls}: accepted is room for at least {needed}, as the scenario has")
        if not has_room(self._jammers, scenario):
            raise InputError(f"jammers={self._jammers}: accepted is room for {jammer_room([scenario])}, as it has")
        width = 1 + max(self._channels)
        one = stack([scenario], [self._channels], capacity=self._walls, width=width, jammers=self._jammers)
        return jax.tree.map(lambda leaf: jnp.asarray(leaf[..., 0]), one)

    def change(self, params: Params, changes: Mapping[str, Any]) -> Params:
        """The same world with other physical values: `{"radio.path_loss_exponent": 3.0, "swarm.speed": x}`.

        Values are numbers, which are checked as settings are, or traced arrays. What follows from them, such as the
        network range, follows. What is not named has the value of the environment's settings, whatever `params` hold;
        the world was made before, and stays.

        Raises InputError for a number that is not accepted, or a name that is no number of the physics: one of radio,
        or of swarm and learning what `SwarmParameters` have or failures are made of.
        """
        plain: dict[str, dict[str, Any]] = {name: {} for name in ("radio", "swarm", "learning")}
        traced: dict[str, dict[str, Any]] = {name: {} for name in plain}
        for name, value in changes.items():
            section, last = self._physical(name)
            (traced if isinstance(value, jax.Array) else plain)[section][last] = value
        checked = {name: dataclasses.replace(getattr(self.settings, name), **plain[name]) for name in plain}
        sections = {name: SimpleNamespace(**(vars(checked[name]) | traced[name])) for name in plain}
        radio = RadioParameters.of(sections["radio"])
        body = SwarmParameters.of(SimpleNamespace(world=self.settings.world, **sections))
        return dataclasses.replace(params, physics=dataclasses.replace(params.physics, radio=radio, swarm=body))

    def _physical(self, name: str) -> tuple[str, str]:
        """Section and field of a number of the physics; see `change`."""
        section, _, last = str(name).partition(".")
        body = {field.name for field in dataclasses.fields(SwarmParameters)} | set(CHANGEABLE)
        known = {
            "radio": {field for field, value in vars(self.settings.radio).items() if type(value) in (int, float)},
            "swarm": body & vars(self.settings.swarm).keys(),
            "learning": body & vars(self.settings.learning).keys(),
        }
        if last not in known.get(section, ()):
            raise refuse("change", name, "the name of a number of the physics, such as radio.power_dbm")
        return section, last

    # The episode.

    def reset(self, key: jax.Array, params: Params) -> tuple[Seen, EnvState]:
        """Deploy the swarm.

        Args:
            key: a JAX random key, or two words uint32 [2]; all that is drawn in the episode follows from it.
            params: see `Params`.
        """
        physics = params.physics
        words = jax.random.key_data(key) if jnp.issubdtype(key.dtype, jax.dtypes.prng_key) else key
        return self._observed(swarm.begin(params.arena, words.reshape(-1)[-2:], physics), params)

    def step(
        self, key: jax.Array, state: EnvState, action: jax.Array, params: Params
    ) -> tuple[Seen, EnvState, jax.Array, jax.Array, jax.Array, dict[str, jax.Array]]:
        """Everybody acts at once. An episode that is over stands still, with reward 0; nothing is reset by itself.

        Args:
            key: not looked at, since what an episode draws follows from the key of `reset`; there for the convention.
            state: from `reset` or `step`.
            action: int [n], which of `actions` each agent takes; a number that is none is to do nothing.
            params: see `Params`.

        Returns:
            observation, state, reward float32 [n], terminated bool (the task is done), truncated bool (time is up),
            and info: packets delivered and waiting, steps, and each agent's contribution.
        """
        physics = params.physics
        seen = _with_params(state.seen, params)
        running = seen.view.running
        known = jnp.concatenate([self._actions, np.array([NO_ACTION], np.int32)])
        nothing = np.int32(len(known) - 1)
        number = known[jnp.where((action >= 0) & (action < nothing), action.astype(jnp.int32), nothing)]
        after, reward, outcome = swarm.act(jnp.where(running, number, np.int32(NO_ACTION)), seen, physics)
        shares = after.t % np.int32(self._period) == 0
        after = jax.tree.map(partial(jnp.where, shares), knowledge.share(after), after)
        after = jax.tree.map(partial(jnp.where, running), after, seen.view.state)
        observation, following = self._observed(after, params)
        going = physics.task.going_on(after, params.arena, physics.swarm)
        late = after.t >= params.arena.time_limit
        info = {
            "delivered": after.delivered,
            "waiting": after.waiting,
            "steps": after.t,
            "contribution": after.contribution,
        }
        rewarded = jnp.where(outcome.intent.acts & running, reward, np.float32(0))
        return observation, following, rewarded, ~going, going & late, info

    def observe(self, state: EnvState, params: Params) -> Seen:
        """What the agents see of a state: the observation that `reset` or `step` returned with it."""
        seen = _with_params(state.seen, params)
        numbers = np.array(self._grammar.clauses)
        bits = seen.truth[numbers // WORD_BITS] >> (numbers % WORD_BITS).astype(np.uint32)[:, None]
        return Seen(
            clauses=((bits & np.uint32(1)) == np.uint32(1)).T,
            features=features(seen.view).T,
            action_mask=self._action_mask(seen.view),
        )

    def _observed(self, state: State, params: Params) -> tuple[Seen, EnvState]:
        _, seen = swarm.observe(state, params.arena, params.physics)
        following = EnvState(_without_params(seen))
        return self.observe(following, params), following

    def _action_mask(self, view: View) -> jax.Array:
        useful = action_mask(view, self._grammar.actions, self._physics.language)
        return jnp.concatenate([useful, jnp.ones((1, self.agents), bool)]).T


def _whole_blocks(walls: tuple[int, int]) -> tuple[int, int]:
    """Room for at least so many walls."""
    if not isinstance(walls, tuple) or len(walls) != 2:
        raise refuse("walls", walls, "two whole numbers: of vertical and horizontal walls")
    vertical, horizontal = (-(-whole("walls", count, 0, MOST_WALLS) // BLOCK) * BLOCK for count in walls)
    return vertical, horizontal


def _without_params(seen: Observation) -> Observation:
    view: Any = dataclasses.replace(seen.view, arena=None, radio=None, swarm=None)  # type: ignore[arg-type]
    return dataclasses.replace(seen, view=view)


def _with_params(seen: Observation, params: Params) -> Observation:
    physics = params.physics
    view = dataclasses.replace(seen.view, arena=params.arena, radio=physics.radio, swarm=physics.swarm)
    return dataclasses.replace(seen, view=view)


class AutoReset:
    """An environment that deploys the swarm anew when an episode is over; `info["last"]` is then its last observation.

    Everything else is that of the environment within.
    """

    def __init__(self, env: Env) -> None:
        self.env = env

    def __getattr__(self, name: str) -> Any:
        return getattr(self.env, name)

    def step(
        self, key: jax.Array, state: EnvState, action: jax.Array, params: Params
    ) -> tuple[Seen, EnvState, jax.Array, jax.Array, jax.Array, dict[str, Any]]:
        """As `Env.step`, but where the episode is over, observation and state are those of a new one from `key`."""
        observation, after, reward, terminated, truncated, info = self.env.step(key, state, action, params)
        fresh = self.env.reset(key, params)
        over = terminated | truncated
        following, following_state = jax.tree.map(partial(jnp.where, over), fresh, (observation, after))
        return following, following_state, reward, terminated, truncated, {**info, "last": observation}


def make(name: str, changes: Mapping[str, Any] | None = None, *, seed: int = 0, task: Delivery | None = None) -> Env:
    """The environment of a world by its name, `open_short` to `urban_jammed_long`.

    Args:
        name: environment and range.
        changes: other settings by the names that the command line has, `{"swarm.agents": 8, "grammar": "both"}`.
        seed: of the world.
        task: when an episode is over, and what a step is worth; by default the one that the settings name.

    Raises:
        InputError: a name that is none, or an impossible setting.
    """
    if name not in CELLS:
        raise refuse("make", name, "one of " + ", ".join(CELLS))
    kind, _, far = name.rpartition("_")
    changes = of_kind("changes", {} if changes is None else changes, dict)
    given = {f"world.{field}": value for field, value in dataclasses.asdict(World.preset(kind, far)).items()}
    return Env(settings_from({**given, "seed": seed, **changes}), task=task)
