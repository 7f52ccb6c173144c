"""The task: when an episode is over, what it scores, what a step is worth; and tasks of a user's own."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax import episode as episodes
from slcs2_jax.config import InputError, Settings, Swarm, Task
from slcs2_jax.episode import Parameters
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm.reward import Progress
from slcs2_jax.swarm.task import Delivery, Score, task_of
from tests.builders import registered


def score(delivered, steps, **measures):
    return Score(delivered=delivered, packets=300, steps=steps, time_limit=1000, measures=measures)


@pytest.mark.parametrize(
    ("delivered", "steps", "fitness"), [(300, 250, 0.75), (0, 1000, -1.0), (150, 1000, -0.5), (300, 1000, 0.0)]
)
def test_fitness_is_the_share_delivered_less_the_share_of_time(delivered, steps, fitness):
    assert Delivery().fitness(score(delivered, steps)) == fitness


@pytest.mark.parametrize(
    ("fields", "going"),
    [
        ({}, True),
        ({"delivered": 299, "waiting": 1}, True),
        ({"delivered": 300, "waiting": 0}, False),
        ({"t": 999}, True),
        ({"t": 1000}, False),
    ],
)
def test_an_episode_goes_on_until_all_is_delivered_or_time_is_up(make, fields, going):
    arena, physics = make.arena([(0, 0), (9, 0)]), make.physics(packets=300)
    assert bool(Delivery().running(make.state(arena, **fields), arena, physics.swarm)) == going


@dataclasses.dataclass(frozen=True)
class Crowded(Delivery):
    """Of a user's own: over in step 3, scores how far the swarm has come."""

    def going_on(self, state, arena, parameters):
        return state.t < np.int32(3)

    def measure(self, state, arena):
        return {"farthest": jnp.max(state.x, axis=0)}

    def fitness(self, score):
        return float(score.measures["farthest"]) / 100


@dataclasses.dataclass(frozen=True)
class Flat:
    """A reward of a user's own."""

    def __call__(self, view, after, outcome):
        return jnp.where(outcome.intent.moves, jnp.float32(2), jnp.float32(-1))


PARTS = {"task": {"crowded": Crowded}, "reward": {"flat": Flat}}


def own_settings():
    """Settings that name the parts above, which must be registered."""
    return Settings(task=Task(name="crowded", reward="flat"), swarm=Swarm(agents=2))


def test_the_settings_name_it():
    assert task_of(Settings()) == Delivery(Progress())
    with registered(PARTS):
        own = own_settings()
        assert task_of(own) == Crowded(Flat())
        assert hash(task_of(own)) == hash(Crowded(Flat()))
    with pytest.raises(InputError, match=r"^task.name=crowded: accepted is one of delivery, or"):
        own_settings()
    with pytest.raises(InputError, match=r"^task.name=crowded: accepted is one of delivery, or"):
        task_of(own)
    with pytest.raises(InputError, match=r"^task.reward=flat: accepted is one of progress, or"):
        Task(reward="flat")


def test_an_own_task_decides_the_end_and_what_is_measured(make):
    with registered(PARTS):
        parameters = Parameters.of(own_settings())
    arena = make.arena([(40, 0), (9, 0)])
    given = Rules.like(1, 2, parameters.physics.language)
    episode = episodes.begin(arena, given, jnp.zeros(2, jnp.uint32), parameters)
    assert not episodes.over(episode, parameters)
    late = make.replace(episode, state=make.state(arena, t=3))
    assert episodes.over(late, parameters)
    ended = make.replace(episode, state=make.state(make.arena([(40, 0), (9, 0)], time_limit=2), t=2))
    assert episodes.over(make.replace(ended, arena=make.arena([(40, 0), (9, 0)], time_limit=2)), parameters)
    result = episodes.result(late, parameters)
    assert result.measures == {"farthest": 40}
    found = parameters.physics.task.fitness(score(0, 3, farthest=np.float32(40)))
    assert found == pytest.approx(0.4)


def worth(make, task):
    """Everybody's reward under a task in a step in which agent 0 moves."""
    arena, physics = make.arena([(40, 0), (9, 0)]), make.physics()
    state, links = make.state(arena), make.links(2)
    meant = make.intent(2, moves={0: (0, 50, 0)}, collects={1: (0, 1.0)})
    after, air = make.transfer(state, links, meant, physics.radio)
    physics = make.replace(physics, task=task)
    return make.reward(make.look(state, links, arena, physics), after, meant, air, physics)


def test_an_own_reward_is_paid(make):
    assert worth(make, Delivery(Flat())).tolist() == [2, -1]


def refused(make, task, told):
    with pytest.raises(InputError) as found:
        worth(make, task)
    assert str(found.value) == told


@dataclasses.dataclass(frozen=True)
class Odd:
    """A reward that is none."""

    dtype: type = np.float32
    size: int = 2

    def __call__(self, view, after, outcome):
        return jnp.ones(self.size, self.dtype)


def test_wrong_shapes_and_types_are_named_in_one_line(make):
    @dataclasses.dataclass(frozen=True)
    class Endless(Delivery):
        def going_on(self, state, arena, parameters):
            return state.holding

    @dataclasses.dataclass(frozen=True)
    class Counting(Delivery):
        def going_on(self, state, arena, parameters):
            return state.waiting

    refused(make, Delivery(Odd(np.int32)), "reward 'Odd': returned int32[2]; accepted is float32[2]")
    refused(make, Delivery(Odd(size=5)), "reward 'Odd': returned float32[5]; accepted is float32[2]")
    refused(make, Endless(), "task 'Endless': returned bool[2]; accepted is bool[]")
    refused(make, Counting(), "task 'Counting': returned int32[]; accepted is bool[]")
