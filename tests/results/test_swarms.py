"""The evolved swarms that come with the package."""

import re
from pathlib import Path

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


PAGE = Path(__file__).parents[2] / "docs" / "howto" / "swarms.md"


def told() -> dict[str, tuple[float, ...]]:
    """Of every swarm on the page: mean fitness in its own world, and in thirty that it has not seen."""
    said = PAGE.read_text(encoding="utf-8").replace("−", "-")
    header, _, *rows = (
        [cell.strip(" `") for cell in line.strip("|").split("|")]
        for line in said[said.index("<!-- swarms") :].splitlines()
        if line.startswith("|")
    )
    return {
        row[0] + ("" if grammar == "main" else grammar): tuple(map(float, re.findall(r"-?[\d.]+", cell)))
        for row in rows
        for grammar, cell in zip(header[1:], row[1:], strict=True)
    }


def test_the_page_has_every_swarm_and_there_is_one_for_each_world_and_grammar():
    assert sorted(told()) == swarm_names()
    assert len(swarm_names()) == 8 * 4


@pytest.mark.slow
@pytest.mark.parametrize("name", swarm_names()[::8])
def test_a_swarm_does_as_well_as_the_page_says(name, capsys):
    own = f"seed={load_solution(swarm_file(name)).instance_seed}"
    for figure, more in zip(told()[name], ([own, "instances=1", "deployments=120"], ["seed=9500000"]), strict=True):
        assert cli.main(["evaluate", f"swarm={name}", "instances=30", "compute.native=on", *more]) == 0
        [mean] = re.findall(r"^ +mean +(-?[\d.]+)", capsys.readouterr().out, re.MULTILINE)
        assert float(mean) == figure


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
