"""The scripts that make the README's picture: random search spends what evolution spent, curves are what rows say."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from slcs2_jax.config import Compute, Rules, Search, Settings, Swarm, World
from slcs2_jax.results import read_run
from slcs2_jax.running import driver

SCRIPTS = Path(__file__).resolve().parent.parent / "scripts"
INSTANCES = 2


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, SCRIPTS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(name: str, *arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, SCRIPTS / f"{name}.py", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def folders(tmp_path_factory) -> tuple[Path, Path]:
    """A small evolution and the random search with its budget."""
    folder = tmp_path_factory.mktemp("scripts")
    settings = Settings(
        world=World(distance=190.0, time_limit=200),
        swarm=Swarm(agents=3, packets=4),
        rules=Rules(rules=10),
        search=Search(generations=4, fresh_deployments=2),
        compute=Compute(devices=1, cache=False, chunk=50),
        instances=INSTANCES,
        run_dir=str(folder / "evolved"),
    )
    driver.evolve([settings])
    done = run("random_search", folder / "evolved", folder / "random")
    assert done.returncode == 0, done.stderr
    return folder / "evolved", folder / "random"


def counterparts(folder: Path) -> list:
    return [read_run(folder / f"seed_{seed:03d}") for seed in range(INSTANCES)]


def test_random_search_spends_the_evaluations_of_the_evolution(folders):
    evolved = read_run(folders[0])
    assert evolved.summary is not None
    for instance, random in zip(evolved.summary["instances"], counterparts(folders[1]), strict=True):
        [other] = random.summary["instances"]
        assert instance["seed"] == other["seed"]
        # the last solution may be deployed again when the budget is spent
        assert instance["evaluations"] <= other["evaluations"] <= instance["evaluations"] + 5
        assert (random.settings.world, random.settings.search.name) == (evolved.settings.world, "random")


def test_every_solution_of_random_search_is_new_and_random(folders):
    runs = counterparts(folders[1])
    for row in [row for run in runs for row in run.rows]:
        assert (row["parent"], row["copied"], row["explorations"]) == (-1, 0, 0)
        assert row["fresh"] == 30
        if row["generation"]:
            assert row["novelty"] > 0.5
    first = [row["fitness"] for row in read_run(folders[0]).rows if row["generation"] == 0]
    assert first == [run.rows[0]["fitness"] for run in runs], "both begin with the same random solution"


def test_a_folder_without_summary_is_refused(folders, tmp_path):
    unfinished = tmp_path / "unfinished"
    unfinished.mkdir()
    for name in ("config.yaml", "grammar.bnf"):
        (unfinished / name).write_text((folders[0] / name).read_text())
    done = run("random_search", unfinished, tmp_path / "out")
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "is not finished" in done.stderr
    assert not (tmp_path / "out").exists()


def test_runs_of_an_experiment_have_counterparts_of_their_own(folders, tmp_path):
    settings = read_run(folders[0]).settings
    apart = [
        dataclasses.replace(settings, instances=1, seed=seed, run_dir=str(tmp_path / "evolved" / f"seed_{seed:03d}"))
        for seed in (0, 1)
    ]
    driver.evolve(apart)
    done = run("random_search", tmp_path / "evolved", tmp_path / "random")
    assert done.returncode == 0, done.stderr
    for together in counterparts(folders[1]):
        found = read_run(str(tmp_path / "random" / f"seed_{together.settings.seed:03d}"))
        assert found.settings.seed == together.settings.seed
        assert [row["best"] for row in found.rows] == [row["best"] for row in together.rows]


def test_the_curve_rises_when_a_solutions_last_deployment_is_done():
    def rows(instance: int, *made: tuple[int, float]) -> list[dict]:
        return [
            {"instance": instance, "generation": number, "deployments": deployments, "best": best}
            for number, (deployments, best) in enumerate(made)
        ]

    shorter = SimpleNamespace(path="run", rows=rows(0, (2, -0.5), (1, -0.5), (3, 0.3)) + rows(1, (1, -1), (4, 0.0)))
    curves = script("plot_curves").curves([shorter])
    np.testing.assert_array_equal(curves, [[-0.5, -0.5, -0.5, -0.5, -0.5], [-1, -1, -1, -1, 0.0]])
    longer = SimpleNamespace(path="run", rows=[*shorter.rows, *rows(1, (1, -1), (4, 0.0), (2, 0.5))[2:]])
    curves = script("plot_curves").curves([longer])
    np.testing.assert_array_equal(curves, [[-0.5] * 5 + [0.3], [-1, -1, -1, -1, 0.0, 0.0]])
    alone = [
        SimpleNamespace(path=f"run {number}", rows=[row for row in longer.rows if row["instance"] == number])
        for number in range(2)
    ]
    for one in alone:  # as an experiment leaves them: an instance for each run
        one.rows = [{**row, "instance": 0} for row in reversed(one.rows)]
    np.testing.assert_array_equal(script("plot_curves").curves(alone), curves)


def test_the_interval_is_students():
    from scipy import stats

    values = np.random.default_rng(0).normal(size=(8, 3))
    low, high = stats.t.interval(0.9, 7, loc=values.mean(axis=0), scale=stats.sem(values, axis=0))
    np.testing.assert_allclose(script("plot_curves").half_width(values), (high - low) / 2)


def test_picture_and_table(folders, tmp_path):
    pytest.importorskip("matplotlib", reason="the extra plot is not installed")
    done = run("plot_curves", tmp_path / "picture.png", "small", *folders)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    lines = done.stdout.splitlines()
    assert len(lines) == 4
    summary = json.loads((folders[0] / "summary.json").read_text())
    mean = np.mean([instance["best_fitness"] for instance in summary["instances"]])
    assert lines[2].startswith(f"| small | evolution | {INSTANCES} |")
    assert f" {mean:.3f} ± " in lines[2]


def test_one_instance_is_too_few_for_an_interval():
    finished = SimpleNamespace(path="run", rows=[{"instance": 0, "generation": 0, "deployments": 1, "best": 0.0}])
    module = script("plot_curves")
    with pytest.raises(module.InputError, match=r"1 instance\(s\)"):
        module.curves([finished])
