"""What an evaluation takes from the solution and what from the command line."""

import dataclasses

import pytest

from slcs2_jax.config import InputError, Learning, Radio, Settings, Swarm, World, settings_to_dict
from slcs2_jax.config.overlay import evaluation_settings

EVOLVED = Settings(
    world=World.preset("urban", "long"),
    radio=Radio(noise_dbm=-90.0),
    swarm=Swarm(agents=5, speed=1.0),
    learning=Learning(alpha_q=0.3),
    seed=7,
    instances=2,
    run_dir="elsewhere",
)


def evaluate(settings: Settings, *overrides: str) -> Settings:
    return evaluation_settings(EVOLVED, settings_to_dict(settings), overrides)


def test_nothing_given_is_as_it_evolved_but_for_seeds_and_folder():
    found = evaluate(Settings(seed=0, instances=30))
    assert found == dataclasses.replace(EVOLVED, seed=0, instances=30, run_dir=None)


def test_a_group_replaces_what_it_sets_and_no_more():
    found = evaluate(Settings(world=World.preset("jammed", "short")), "environment=jammed")
    assert (found.world.environment, found.world.jammer, found.world.buildings) == ("jammed", True, False)
    assert found.world.distance == 1000.0
    assert found.radio.noise_dbm == -90.0
    assert evaluate(Settings(), "radio=default").radio == Radio()


def test_a_value_given_counts_even_if_it_is_the_default():
    assert evaluate(Settings(), "learning.alpha_q=0.15").learning.alpha_q == 0.15
    assert evaluate(Settings(), "swarm.speed=2.0").swarm == Swarm(agents=5, speed=2.0)


def test_what_the_solution_decides():
    with pytest.raises(InputError, match=r"swarm\.agents=12: accepted is 5, as the solution has it"):
        evaluate(Settings(), "swarm.agents=12")
