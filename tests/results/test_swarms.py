"""The evolved swarms that come with the package."""

import pytest

from slcs2_jax import cli
from slcs2_jax.results import load_solution
from slcs2_jax.results.swarms import swarm_file, swarm_names


@pytest.mark.parametrize("name", swarm_names())
def test_a_swarm_is_named_after_its_world(name):
    one = load_solution(swarm_file(name))
    world, grammar = one.settings.world, one.settings.rules.grammar
    assert name == f"{world.range}_{world.environment}" + (f"_{grammar}" if grammar != "main" else "")
    assert one.instance_seed >= 0
    assert one.fitness > 0


def test_the_commands_take_a_swarm_by_its_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    name = swarm_names()[0]
    assert cli.main(["rules", f"swarm={name}", "replay=off", "agent=3", "top=1"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(name.split("_")[0])
    assert cli.main(["rules", str(swarm_file(name)), "replay=off", "agent=3", "top=1"]) == 0
    assert capsys.readouterr().out == told
    assert cli.main(["replay", f"swarm={name}", "end=40", "out=trace.csv"]) == 0
    assert (tmp_path / "trace.csv").stat().st_size > 100
    assert cli.main(["evaluate", f"swarm={name}", "instances=1", "world.time_limit=40", "run_dir=there"]) == 0
    assert f"swarm: {name}" in (tmp_path / "there" / "config.yaml").read_text()


@pytest.mark.parametrize("command", ["rules", "replay", "evaluate"])
def test_a_swarm_that_there_is_not(command, capsys):
    assert cli.main([command, "swarm=../secret"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert line == "slcs2: error: swarm=../secret: accepted is one of " + ", ".join(swarm_names())
