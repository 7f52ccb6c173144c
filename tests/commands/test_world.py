"""slcs2 world, and worlds in files through the commands that take them."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from slcs2_jax import cli
from slcs2_jax.config import Settings, Swarm, World
from slcs2_jax.results import load_solution, read_run
from slcs2_jax.world.scenario import make_scenario

SMALL = ["generations=1", "instances=1", "swarm.agents=3", "swarm.packets=3", "rules.rules=5",
         "search.fresh_deployments=1", "compute.devices=1"]  # fmt: skip
TEXT = """\
sink: [150, 20]
time_limit: 60
walls: [{corner: [60, -10], opposite: [80, 30]}]
jammers: [{place: [90, 50], emission: constant, power_db: -6}]
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "yard.yaml"
    path.write_text(TEXT)
    return path


def test_it_says_what_is_there(capsys):
    assert (
        cli.main(["world", "environment=urban_jammed", "seed=4", "jammers.count=2", "jammers.emission=sweeping"]) == 0
    )
    said = capsys.readouterr().out
    made = make_scenario(Settings(world=World.preset("urban_jammed")), 4)
    assert f"walls      {len(made.vertical)} across and {len(made.horizontal)} along" in said
    x, y = made.jammers[0].place
    assert f"jammer 0   ({x:.1f}, {y:.1f}); sweeping, fixed, +0 dB" in said
    assert "jammer 1" in said
    assert "(600.0, 0.0)" in said


def test_there_and_back(tmp_path, capsys):
    out = tmp_path / "w.yaml"
    assert cli.main(["world", "environment=urban", "seed=4", f"save={out}"]) == 0
    first = capsys.readouterr().out
    assert cli.main(["world", f"world={out}", "seed=4"]) == 0
    again = capsys.readouterr().out
    assert first.splitlines()[1:4] == again.splitlines()[1:4]
    assert set(yaml.safe_load(out.read_text())) == {
        "sink", "sink_estimate", "time_limit", "wall_thickness", "walls", "jammers", "starts",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["save=w.txt"], "save=w.txt: accepted is a new file"),
        (["save=nowhere/w.yaml"], "save=nowhere/w.yaml: accepted is a new file"),
        (["-m", "seed=1,2"], "option -m"),
        (["world=none.yaml"], "world.file=none.yaml"),
        (["world.distance=-1"], "world.distance=-1"),
        (["world.colour=red"], "world.colour"),
    ],
)
def test_bad_input_gets_one_line(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["world", *arguments]) == 2
    caught = capsys.readouterr()
    assert says in caught.err
    assert caught.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_run_keeps_its_world_and_needs_the_file_no_more(file, tmp_path, capsys):
    run = tmp_path / "run"
    assert cli.main(["evolve", f"world={file}", *SMALL, f"run_dir={run}"]) == 0
    assert (run / "world.yaml").read_text() == TEXT
    file.unlink()
    assert cli.main(["resume", str(run), "generations=2"]) == 0
    found = read_run(run)
    assert found.settings.world.content == TEXT
    assert {row["generation"] for row in found.rows} == {0, 1}
    solution = load_solution(run / "solutions" / "instance_000_best.npz")
    scenario = make_scenario(solution.settings, 0)
    assert scenario.sink.tolist() == [150, 20]
    assert scenario.jammers[0].emission == "constant"
    assert scenario.time_limit == 60
    assert cli.main(["evaluate", f"solution={run}/solutions/instance_000_best.npz", "instances=2"]) == 0
    assert cli.main(["repeat", str(run)]) == 0
    capsys.readouterr()


@pytest.mark.slow
def test_a_solution_is_evaluated_in_a_world_from_a_file(file, tmp_path, capsys):
    run, other = tmp_path / "run", tmp_path / "evaluated"
    assert cli.main(["evolve", "world.time_limit=40", *SMALL, f"run_dir={run}"]) == 0
    solution = f"solution={run}/solutions/instance_000_best.npz"
    assert cli.main(["evaluate", solution, f"world={file}", "instances=2", f"run_dir={other}"]) == 0
    assert (other / "world.yaml").read_text() == TEXT
    capsys.readouterr()


def test_settings_say_what_the_command_line_says(file):
    by_hand = make_scenario(Settings(world=World.from_file(file), swarm=Swarm(agents=3)), 0)
    np.testing.assert_array_equal(by_hand.vertical[:, 0], [60, 80])
    np.testing.assert_array_equal(by_hand.horizontal[:, 0], [-10, 30])
