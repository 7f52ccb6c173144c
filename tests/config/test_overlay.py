"""What an evaluation takes from the solution and what from the command line."""

import dataclasses

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from slcs2_jax.config import InputError, Learning, Radio, Settings, Swarm, World
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.compose import run_hydra
from slcs2_jax.config.overlay import deployment_primary, deployment_settings

EVOLVED = Settings(
    world=World.preset("urban", "long"),
    radio=Radio(noise_dbm=-90.0),
    swarm=Swarm(agents=5, speed=1.0),
    learning=Learning(alpha_q=0.3),
    seed=7,
    instances=2,
    run_dir="elsewhere",
)


def deploy(*arguments: str, solution: Settings | None = EVOLVED) -> Settings:
    found: list[Settings] = []

    def together(jobs):
        found.extend(deployment_settings(job.config, solution) for job in jobs)
        return [0.0] * len(jobs)

    primary = deployment_primary("evaluate", solution, own={}, instances=30)
    run_hydra(primary, CommandLine.parse(arguments), together)
    [one] = found
    return one


def test_nothing_given_is_as_it_evolved_but_for_seeds_and_folder():
    assert deploy() == dataclasses.replace(EVOLVED, seed=0, instances=30, run_dir=None)


def test_without_a_solution_it_is_the_defaults():
    assert deploy(solution=None) == Settings(instances=30)
    assert deploy("environment=urban", solution=None).world == World.preset("urban")


def test_a_group_replaces_what_it_sets_and_no_more(tmp_path):
    found = deploy("environment=jammed")
    assert (found.world.environment, found.world.jammer, found.world.buildings) == ("jammed", True, False)
    assert found.world.distance == 1000.0
    assert found.radio.noise_dbm == -90.0
    (tmp_path / "radio").mkdir()
    (tmp_path / "radio" / "mine.yaml").write_text("shadowing_db: 1.0\n")
    radio = deploy("--config-dir", str(tmp_path), "radio=mine").radio
    assert (radio.shadowing_db, radio.noise_dbm) == (1.0, -90.0)


def test_a_value_given_counts_even_if_it_is_the_default():
    assert deploy("learning.alpha_q=0.15").learning.alpha_q == 0.15
    assert deploy("swarm.speed=2.0").swarm == Swarm(agents=5, speed=2.0)


PIECES = st.sampled_from(["${", "}", "\\", "$", "{", "oc.env:HOME", "seed", "'", "a", "\n", "?"])


@settings(max_examples=25)
@example(name="\\${seed}")
@given(name=st.lists(PIECES, min_size=1, max_size=6).map("".join).filter(lambda text: text.strip() and text != "???"))
def test_texts_of_a_saved_solution_are_taken_as_they_are(name):
    """`${...}` would be looked up: in a file from elsewhere it must mean nothing."""
    evolved = dataclasses.replace(EVOLVED, rules=dataclasses.replace(EVOLVED.rules, grammar=name))
    assert deploy("seed=3", solution=evolved).rules.grammar == name


def test_a_text_that_means_a_missing_value_is_refused():
    evolved = dataclasses.replace(EVOLVED, rules=dataclasses.replace(EVOLVED.rules, grammar="???"))
    with pytest.raises(InputError, match=r"grammar: has no default; accepted is .*grammar=VALUE"):
        deploy("seed=3", solution=evolved)


def test_another_file_of_a_world_takes_the_place_of_the_solutions(tmp_path):
    text = "sink: [100, 0]\n"
    (tmp_path / "mine.yaml").write_text(text)
    evolved = dataclasses.replace(EVOLVED, world=World(file="theirs.yaml", content="sink: [50, 0]\n"))
    kept, other = deploy(solution=evolved).world, deploy(f"world={tmp_path}/mine.yaml", solution=evolved).world
    assert (kept.file, kept.content) == ("theirs.yaml", "sink: [50, 0]\n")
    assert (other.file, other.content) == (f"{tmp_path}/mine.yaml", text)
    none = deploy("world.file=null", solution=evolved).world
    assert (none.file, none.content) == (None, None)


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("swarm.agents=12", r"swarm\.agents=12: accepted is 5, as the solution has it"),
        ("grammar=both", "grammar=both: accepted is main, as the solution has it"),
        ("generations=3", "generations: no setting of slcs2 evaluate"),
        ("search=random", "search: no setting of slcs2 evaluate"),
        ("checkpoint.seconds=3", r"checkpoint\.seconds: no setting of slcs2 evaluate"),
    ],
)
def test_what_the_solution_decides_and_what_an_evaluation_does_not_have(override, says):
    with pytest.raises(InputError, match=says):
        deploy(override)
