"""Slots: what an episode comes to does not depend on where, when and beside whom it is computed."""

import dataclasses
import functools
import itertools
import operator

import jax
import numpy as np
import pytest

from slcs2_jax.config import InputError, Radio, Rules, Settings, Swarm, World
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar import Grammar, load_grammar, random_rule_sets
from slcs2_jax.grammar.language import Language
from slcs2_jax.native import library
from slcs2_jax.policy.rules import Rules as Compiled
from slcs2_jax.rollout import LANES, Done, Job, Rollout, Shape
from slcs2_jax.search import deployment_key
from slcs2_jax.world.arena import wall_capacity
from slcs2_jax.world.scenario import Scenario, make_scenario

AGENTS, RULES = 4, 20
COUNTS = ("steps", "delivered", "contribution", "figures.usage")
REALS = ("figures.quality", "figures.strength", "figures.error")
NUMBERS = range(6)  # of the jobs that most tests compare

# near enough for some random rules to deliver every packet before the time limit
SWARM, RULE_SETS = Swarm(agents=AGENTS, packets=4), Rules(rules=RULES)
SETTINGS = {
    "open": Settings(world=World(distance=190.0, time_limit=300), swarm=SWARM, rules=RULE_SETS),
    # net is 54 m at this power
    "urban_jammed": Settings(
        world=dataclasses.replace(World.preset("urban_jammed"), distance=110.0, time_limit=300),
        radio=Radio(power_dbm=6.5),
        swarm=SWARM,
        rules=dataclasses.replace(RULE_SETS, grammar="both"),
    ),
}
everywhere = pytest.mark.parametrize("world", ["open", pytest.param("urban_jammed", marks=pytest.mark.slow)])


@functools.cache
def grammar(world: str) -> Grammar:
    return load_grammar(SETTINGS[world].rules.grammar)


@functools.cache
def scenario(world: str, number: int) -> Scenario:
    return make_scenario(SETTINGS[world], number)


@functools.cache
def rollout(
    world: str = "open", *, devices: int = 1, width: int = LANES, chunk: int = 50, engine: str = "auto"
) -> Rollout:
    """Vacant slots, `width` on each device; kept, because compiling takes seconds. Tests leave them vacant."""
    said = grammar(world)
    shape = Shape(
        agents=AGENTS,
        channels=len(said.channels_used),
        walls=wall_capacity([scenario(world, number) for number in range(20)]),
    )
    language = Language.of([said])
    parameters = Parameters.of(SETTINGS[world], language=language)
    like = Compiled.like(RULES, AGENTS, language)
    return Rollout(
        parameters, shape, like, slots=devices * width, devices=jax.devices()[:devices], chunk=chunk, engine=engine
    )


@functools.cache
def job(world: str, number: int) -> Job:
    """A deployment of a random solution in one of twenty worlds."""
    rules = random_rule_sets(grammar(world), AGENTS, RULES, np.random.default_rng(number))
    site = scenario(world, number % 20)
    return Job(number, site, grammar(world).channels_used, rules, deployment_key(number, 0, 0))


def finish(slots: Rollout, limit: int = 200) -> list[Done]:
    """Advance until no slot holds a job."""
    done = []
    for _ in range(limit):
        done += slots.advance()
        if len(slots.vacant()) == slots.slots:
            return done
    raise AssertionError("episodes do not end")


def play(slots: Rollout, world, numbers, places=None) -> dict[int, Done]:
    """Compute the jobs of these numbers, each in its place, or else in the first slot that is vacant."""
    done: list[Done] = []
    if places is not None:
        for number, place in zip(numbers, places, strict=True):
            slots.place(place, job(world, number))
    else:
        waiting = list(numbers)
        while waiting:
            for slot in slots.vacant()[: len(waiting)]:
                slots.place(slot, job(world, waiting.pop(0)))
            done += slots.advance()
    done += finish(slots)
    assert sorted(one.job.name for one in done) == sorted(numbers)
    return {one.job.name: one for one in done}


def assert_same(left: dict[int, Done], right: dict[int, Done], fields=COUNTS + REALS) -> None:
    assert left.keys() == right.keys()
    for name, field in itertools.product(left, fields):
        found, expected = operator.attrgetter(field)(left[name]), operator.attrgetter(field)(right[name])
        np.testing.assert_array_equal(found, expected, err_msg=f"{field} of job {name}")


@functools.cache
def alone(world: str) -> dict[int, Done]:
    """Each of some jobs by itself in the first slot."""
    return {number: play(rollout(world), world, [number], [0])[number] for number in NUMBERS}


@everywhere
def test_the_jobs_are_worth_comparing(world):
    done = alone(world).values()
    assert any(one.delivered for one in done), "nobody delivers"
    assert len({one.figures.usage.tobytes() for one in done}) == len(done)
    assert all(one.figures.usage.any() and one.figures.error.any() for one in done)
    if world == "open":
        assert len({one.steps for one in done}) > 2, "no episodes end at different times"


@everywhere
def test_any_place_gives_the_same_bits(world):
    assert_same(play(rollout(world), world, NUMBERS, [15, 3, 8, 0, 7, 11]), alone(world))


@everywhere
def test_slots_are_refilled_when_episodes_end_and_give_the_same_bits(world):
    numbers = range(3 * LANES)
    done = play(rollout(world), world, numbers)
    assert_same({number: done[number] for number in NUMBERS}, alone(world))
    assert_same(play(rollout(world), world, numbers[::-1]), done)


def test_a_cancelled_job_never_comes_back_and_leaves_no_trace():
    slots = rollout()
    for place in range(4):
        slots.place(place, job("open", 100 + place))
    slots.cancel(0)  # before it begins
    assert slots.advance() == []
    slots.cancel(1)  # under way
    assert {0, 1} <= set(slots.vacant())
    slots.place(0, job("open", 0))
    slots.place(1, job("open", 1))
    done = {one.job.name: one for one in finish(slots)}
    assert done.keys() == {0, 1, 102, 103}
    assert_same({number: done[number] for number in (0, 1)}, {number: alone("open")[number] for number in (0, 1)})


@everywhere
def test_two_devices_give_the_bits_of_one(world):
    places = [0, LANES - 1, LANES, LANES + 3, 2 * LANES - 1, 5]
    assert_same(play(rollout(world, devices=2), world, NUMBERS, places), alone(world))


def test_other_chunks_give_the_same_bits():
    assert_same(play(rollout(chunk=10), "open", NUMBERS), alone("open"))


@everywhere
def test_other_widths_give_the_same_counts_and_nearly_the_same_reals(world):
    wide = play(rollout(world, width=3 * LANES), world, NUMBERS)
    assert_same(wide, alone(world), COUNTS)
    for number, field in itertools.product(wide, REALS):
        left, right = map(operator.attrgetter(field), (wide[number], alone(world)[number]))
        np.testing.assert_allclose(left, right, rtol=1e-3, atol=1e-3, err_msg=field)


def test_programs_are_compiled_once_for_rollouts_of_the_same_sizes_and_not_again_while_they_play(monkeypatch):
    first = rollout(engine="off")
    traced = []
    monkeypatch.setattr(jax.stages.Traced, "lower", lambda *arguments, **options: traced.append(arguments))
    play(first, "open", range(3))
    again = rollout.__wrapped__(engine="off")
    assert (again._in._advance, traced) == (first._in._advance, [])
    with pytest.raises(AttributeError):
        rollout.__wrapped__(chunk=20, engine="off")
    assert traced


def test_native_slots_need_no_program_of_xla(monkeypatch):
    monkeypatch.setattr(jax.stages.Traced, "lower", None)
    slots = rollout.__wrapped__(chunk=30, engine="on")
    assert_same(play(slots, "open", NUMBERS), alone("open"))


def test_slots_come_in_whole_lanes_per_device_and_chunks_in_whole_sharing_periods():
    slots = rollout(width=LANES - 3, chunk=3)
    assert (slots.slots, len(slots.vacant())) == (LANES, LANES)
    assert slots.steps_per_chunk == SWARM.sharing_period


def test_the_native_chunk_computes_lane_groups_with_a_job_alone():
    slots = rollout(engine="on")
    before, lanes = slots.slot_steps, library.lanes()
    slots.advance()
    assert slots.slot_steps == before
    slots.place(3, job("open", 0))
    slots.advance()
    assert slots.slot_steps - before == lanes * slots.steps_per_chunk
    slots.cancel(3)
    assert slots.vacant() == list(range(slots.slots))


def test_steps_computed_are_counted_for_vacant_slots_too():
    slots = rollout(engine="off")
    before = slots.slot_steps
    slots.advance()
    assert slots.slot_steps - before == LANES * slots.steps_per_chunk


@pytest.mark.parametrize("size", [(AGENTS + 1, RULES), (AGENTS, RULES - 1)])
def test_a_job_of_another_size_is_refused(size):
    rules = random_rule_sets(grammar("open"), *size, np.random.default_rng(0))
    with pytest.raises(InputError, match=r"policy: its arrays are .*; accepted are .*\(3, 20, 4\).*\(20, 4\)"):
        rollout().place(0, dataclasses.replace(job("open", 0), given=rules))
    assert len(rollout().vacant()) == LANES
