"""The command experiment: which runs it asks for, where they go, and one line for any bad input."""

import csv
import io
import re
import sys
import types

import pytest

from slcs2_jax import cli, runtime
from slcs2_jax.commands import experiment
from slcs2_jax.config import InputError, Settings
from slcs2_jax.results import InstanceSummary, RunFolder, RunSummary, read_run
from slcs2_jax.study.experiment import experiments, plan, reported_experiments, run_folder, settings_with

TINY = ("world.time_limit=200", "swarm.agents=2", "rules.rules=5", "search.fresh_deployments=1")


class Driver(types.ModuleType):
    """Stands in for running/driver.py: ends every run at once and keeps what it was called with."""

    def __init__(self) -> None:
        super().__init__("slcs2_jax.running.driver")
        self.calls: list[list[Settings]] = []
        self.deployed: list[list[Settings]] = []

    def evolve(self, settings, **options):
        self.calls.append(list(settings))
        return [self._end(one) for one in settings]

    def deploy_in_runs(self, settings, policy, *, deployments, report=None):
        """Fitness is as the setting and the deployment's number say."""
        self.deployed.append(list(settings))
        kind = types.SimpleNamespace
        return [
            [
                [kind(fitness=one.radio.noise_dbm / 1000 + i / 100, delivered=3, steps=9) for i in range(deployments)]
                for _ in range(one.instances)
            ]
            for one in settings
        ]

    def _end(self, settings):
        generations = settings.search.generations
        if settings.run_dir is None:
            one = types.SimpleNamespace(best_fitness=settings.swarm.packets / 1000)
            return types.SimpleNamespace(instances=[one] * settings.instances)
        folder = RunFolder.open(settings, device="test", texts=lambda: {"grammar.bnf": ""}, record={"width": 16})
        done = len(read_run(folder.path).rows)
        spent = {"deployments": 1, "steps": 9.0}
        folder.append({"instance": 0, "generation": g, "best": g / 1000, **spent} for g in range(done, generations))
        one = InstanceSummary(
            seed=settings.seed,
            generations=generations,
            best_fitness=0.5,
            fresh_mean=0.4,
            fresh_sd=0.1,
            evaluations=1,
            env_steps=9,
        )
        summary = RunSummary(run_dir=str(folder.path), generations=generations, instances=(one,))
        folder.write_summary(summary.to_json())
        folder.close()
        return summary


@pytest.fixture
def driver(monkeypatch, tmp_path):
    import slcs2_jax.running

    stub = Driver()
    monkeypatch.setitem(sys.modules, stub.__name__, stub)
    monkeypatch.setattr(slcs2_jax.running, "driver", stub, raising=False)
    monkeypatch.setattr(runtime, "configure", lambda compute: None)
    monkeypatch.setattr(runtime, "describe_devices", lambda compute: "test")
    monkeypatch.chdir(tmp_path)
    return stub


@pytest.fixture
def silent(monkeypatch):
    """Leaves the report out."""
    monkeypatch.setattr(experiment, "_conclude", lambda name, jobs: None)


def folders(root):
    return sorted(str(path.parent.relative_to(root)) for path in root.rglob("config.yaml"))


def test_every_arm_in_every_cell_in_one_batch(driver, tmp_path):
    assert cli.main(["experiment", "contributions", "instances=2", "generations=3", "run_dir=root"]) == 0
    [call] = driver.calls
    assert len(call) == 3 * 8 * 2
    assert {one.instances for one in call} == {1}
    assert {(one.search.acceptance, one.search.exchange) for one in call} == {
        ("domination", True),
        ("ailta", True),
        ("domination", False),
    }
    assert {(one.world.range, one.world.time_limit) for one in call} == {("short", 20_000), ("long", 40_000)}
    found = folders(tmp_path / "root")
    assert len(found) == 48
    assert "ailta/urban_jammed_long/seed_7001" in found
    for path in found:
        arm, cell, seed = path.split("/")
        settings = read_run(tmp_path / "root" / path).settings
        assert f"{settings.world.environment}_{settings.world.range}" == cell
        assert f"seed_{settings.seed:03d}" == seed
        assert (settings.search.acceptance == "ailta") == (arm == "ailta")
    report = (tmp_path / "root" / "report" / "report.md").read_text()
    assert "Compared after 3 generations of every run." in report


def test_all_arms_see_the_same_scenarios(driver, silent):
    cli.main(["experiment", "contributions", "instances=2", "generations=1", "run_dir=root"])
    [call] = driver.calls
    worlds: dict = {}
    for one in call:
        worlds.setdefault((one.search.acceptance, one.search.exchange), set()).add((one.world, one.seed))
    first, *rest = worlds.values()
    assert all(other == first for other in rest)


def test_what_is_there_is_not_computed_again(driver, silent, capsys):
    tiny = ["environment=open,urban", "range=short", "run_dir=root"]
    assert cli.main(["experiment", "contributions", "instances=1", "generations=2", *tiny]) == 0
    before = len(driver.calls)
    assert cli.main(["experiment", "contributions", "instances=1", "generations=2", *tiny]) == 0
    assert len(driver.calls) == before
    capsys.readouterr()
    cli.main(["experiment", "contributions", "instances=2", "generations=2", *tiny])
    assert "6 of the runs are finished, 6 to go" in capsys.readouterr().err
    cli.main(["experiment", "grammars", "instances=2", "generations=2", *tiny])
    assert "4 of the runs are finished, 12 to go" in capsys.readouterr().err  # main is full
    cli.main(["experiment", "contributions", "instances=2", "generations=3", *tiny])
    assert {one.search.generations for one in driver.calls[-1]} == {3}
    assert len(driver.calls[-1]) == 12


def test_runs_that_have_gone_further_are_as_good(driver, tmp_path):
    tiny = ["instances=1", "environment=open", "range=short", "run_dir=root"]
    cli.main(["experiment", "contributions", "generations=5", *tiny])
    assert cli.main(["experiment", "grammars", "generations=2", *tiny]) == 0
    text = (tmp_path / "root" / "report" / "report.md").read_text()
    assert "Compared after 5 generations of every run." in text
    assert "Compared after 2 generations of every run; the longest has 5." in text


def test_one_arm(driver, silent, tmp_path):
    cli.main(["experiment", "grammars", "arm=power", "instances=1", "generations=1", "range=long", "run_dir=root"])
    assert {path.split("/")[0] for path in folders(tmp_path / "root")} == {"power"}
    assert len(folders(tmp_path / "root")) == 4


def test_the_papers_sizes(driver, silent):
    tiny = ["environment=open", "range=short"]
    for name, instances, arms in (("contributions", 10, 3), ("grammars", 30, 4), ("designed", 30, 1)):
        assert cli.main(["experiment", name, *tiny, f"run_dir={name}"]) == 0
        assert len(driver.calls[-1]) == instances * arms
        assert {one.search.generations for one in driver.calls[-1]} == {500}
    assert len(driver.deployed[-1]) == 30


def test_the_designed_behaviour_is_deployed_once_in_the_same_worlds(driver, tmp_path, capsys):
    tiny = ["environment=open,urban", "range=short", "instances=2", "search.fresh_deployments=3", "run_dir=root"]
    assert cli.main(["experiment", "designed", "generations=2", *tiny]) == 0
    evolved = {(one.world, one.seed) for one in driver.calls[-1]}
    assert {(one.world, one.seed) for call in driver.deployed for one in call} == evolved
    summary = read_run(tmp_path / "root/designed/urban_short/seed_2001").summary
    assert summary is not None
    assert summary["fitness"] == pytest.approx([-0.094, -0.084, -0.074])
    assert "Experiment 2: evolved against designed behaviour: after 2 generations" in capsys.readouterr().out
    calls = len(driver.deployed)
    assert cli.main(["experiment", "designed", "generations=3", *tiny]) == 0  # further evolution is no other deployment
    assert len(driver.deployed) == calls
    assert cli.main(["experiment", "designed", "generations=3", *tiny, "instances=3"]) == 0
    assert [one.seed for call in driver.deployed[calls:] for one in call] == [2, 2002]
    assert cli.main(["experiment", "designed", "generations=3", *tiny, "search.fresh_deployments=4"]) == 2
    assert "search.fresh_deployments=4: run_dir=" in capsys.readouterr().err.splitlines()[-1]


def test_a_behaviour_that_has_changed_is_not_mixed_with_what_it_was(driver, silent, tmp_path, monkeypatch, capsys):
    from slcs2_jax.policy import decision_list as behaviour

    tiny = ["environment=open", "range=short", "generations=1", "run_dir=root", "arm=designed"]
    assert cli.main(["experiment", "designed", "instances=1", *tiny]) == 0
    other = behaviour.parse_decision_list("packet held => move toward sink", name="designed")
    monkeypatch.setattr(behaviour, "load_decision_list", lambda name: other)
    assert cli.main(["experiment", "designed", "instances=2", *tiny]) == 2
    assert "designed was another behaviour when it was deployed there" in capsys.readouterr().err
    assert folders(tmp_path / "root") == ["designed/open_short/seed_000"]


def test_no_two_cells_share_a_seed(driver, silent, tmp_path, capsys):
    tiny = ["instances=2", "generations=1", "range=short", "run_dir=root", "arm=evolved"]
    assert cli.main(["experiment", "designed", *tiny, "seed=7"]) == 0
    assert sorted(one.seed for one in driver.calls[0]) == [7, 8, 1007, 1008, 2007, 2008, 3007, 3008]
    assert cli.main(["experiment", "designed", *tiny, "experiment.apart=0"]) == 0
    assert {one.seed for one in driver.calls[1]} == {0, 1}
    assert cli.main(["experiment", "designed", *tiny, "experiment.apart=-1"]) == 2
    assert "experiment.apart=-1: accepted is a whole number" in capsys.readouterr().err
    assert cli.main(["experiment", "designed", *tiny, "seed=2147483000"]) == 2
    assert "seed=2147484000" in capsys.readouterr().err


def test_a_deployment_that_was_interrupted_while_it_was_written(driver, silent, tmp_path):
    tiny = ["environment=open", "range=short", "instances=1", "generations=1", "run_dir=root", "arm=designed"]
    cli.main(["experiment", "designed", *tiny])
    file = tmp_path / "root/designed/open_short/seed_000/summary.json"
    before = file.read_bytes()
    file.unlink()
    assert cli.main(["experiment", "designed", *tiny]) == 0
    assert file.read_bytes() == before


def test_the_calibration_study_adds_only_what_is_missing(driver, tmp_path, capsys):
    command = ["experiment", "calibration", "instances=1", "calibration.deployments=2", "run_dir=root"]
    levels = "calibration.only=[radio.noise_dbm,swarm.packets]"
    assert cli.main([*command, levels, "calibration.samples=0"]) == 0
    assert len(driver.calls) == 1 + 2 + 4  # defaults and levels, each over all cells at once
    assert {len(call) for call in driver.calls} == {8}
    assert {one.seed for call in driver.calls for one in call} == {1_000_000}  # of no other experiment
    rows = list(csv.DictReader(io.StringIO((tmp_path / "root/calibration/calibration.csv").read_text())))
    packets = [f"swarm.packets={value}" for value in (75, 300, 600, 1000)]  # 150 are the defaults again
    assert [row["settings"] for row in rows] == ["defaults", "radio.noise_dbm=-97", "radio.noise_dbm=-91", *packets]
    assert float(rows[1]["designed short open"]) == pytest.approx((-0.097 + -0.087) / 2)
    assert float(rows[0]["evolved long urban"]) == pytest.approx(0.15)
    assert (tmp_path / "root/calibration/calibration.svg").exists()
    assert "misfit" in capsys.readouterr().out
    assert cli.main([*command, "calibration.only=[radio.noise_dbm]", "calibration.samples=2"]) == 0
    assert len(driver.calls) == 7 + 2
    candidate = "calibration.candidates=[{swarm.packets: 100, swarm.speed: 4}]"
    assert cli.main([*command, "calibration.only=[]", "calibration.samples=0", candidate]) == 0
    assert len(driver.calls) == 9 + 1
    assert {(one.swarm.packets, one.swarm.speed) for one in driver.calls[-1]} == {(100, 4.0)}
    rows = list(csv.DictReader(io.StringIO((tmp_path / "root/calibration/calibration.csv").read_text())))
    assert [row["settings"] for row in rows] == ["defaults", "swarm.packets=100, swarm.speed=4"]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("calibration.samples=3", "calibration.samples=3: accepted is 0 or a power of two"),
        ("calibration.only=[radio.noise]", "calibration.only=.*: accepted is null or a list of settings"),
        ("calibration.deployments=0", "calibration.deployments=0: accepted is a whole number >= 1"),
        ("calibration.levels={swarm.agents:[1]}", "calibration: swarm.agents=1: .*accepted is a whole number from 2"),
        ("calibration.candidates=[3]", "calibration.candidates=.*: accepted is a list of mappings of settings"),
        ("calibration.candidates=[{swarm.sped: 4}]", "swarm.sped: no such setting"),
        ("calibration.candidates=[{swarm.speed: -4}]", "swarm.speed=-4: accepted is a finite number"),
        ("calibration.joint={swarm.agent:[1,2]}", "swarm.agent: no such setting"),
    ],
)
def test_an_impossible_calibration_study(driver, given, says, tmp_path, capsys):
    assert cli.main(["experiment", "calibration", given]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert re.search(says, line)
    assert not driver.calls
    assert not list(tmp_path.iterdir())


def test_an_experiment_of_ones_own(driver, silent, tmp_path):
    (tmp_path / "mine" / "experiment").mkdir(parents=True)
    (tmp_path / "mine" / "experiment" / "donors.yaml").write_text(
        "# @package _global_\ninstances: 1\nexperiment:\n  name: donors\n  title: Mine\n"
        "  arms: {with: {}, without: {exchange: false, grammar: power}}\n"
    )
    tiny = ["generations=1", "environment=open", "range=short", "run_dir=root"]
    assert cli.main(["experiment", "donors", *tiny, "--config-dir", "mine"]) == 0
    assert folders(tmp_path / "root") == ["no_exchange_power/open_short/seed_000", "slcs2/open_short/seed_000"]
    assert cli.main(["experiment", "donors", *tiny]) == 2


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "accepted is one of ablation, calibration, contributions, control, designed, grammars, searches"),
        (["contribution"], "experiment=contribution: accepted is one of"),
        (["contributions", "arm=partial"], "arm=partial: accepted is one of all, full, no_novelty, no_exchange"),
        (["contributions", "acceptance=ailta"], "arm=no_novelty: comes to the same settings as full"),
        (["contributions", "environment=mars"], "environment=mars: accepted is one of"),
        (["contributions", "instances=0"], "instances=0: accepted is a whole number from 1"),
        (["contributions", "cells=[open_short]"], "'?cells'?"),
        (["contributions", "experiment.arm={mine: {}}"], "setting=experiment.arm: accepted is one of experiment.name"),
        (["calibration", "calibration.level={seed: [1]}"], "setting=calibration.level: accepted is one of calibration"),
        (["contributions", "hydra/launcher=cloud"], "hydra/launcher=cloud: accepted is one of"),
        (["contributions", "experiment=designed"], "experiment: given twice"),
        (["contributions", "--all"], "option=--all"),
        (["grammars", "+experiment.arms.mine={no_such: 1}"], "no_such: no such setting"),
        (["contributions", "world.distance=200", "environment=jammed"], "no place for the jammer"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_made(driver, arguments, says, tmp_path, capsys):
    assert cli.main(["experiment", *arguments]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert re.search(says, line)
    assert not driver.calls
    assert not list(tmp_path.iterdir())


def test_a_run_folder_that_holds_another_run(driver, silent, tmp_path, capsys):
    tiny = ["instances=1", "generations=1", "environment=open", "range=short", "run_dir=root"]
    cli.main(["experiment", "contributions", *tiny])
    before = {path: path.read_bytes() for path in (tmp_path / "root").rglob("*.yaml")}
    assert cli.main(["experiment", "contributions", *tiny, "radio.noise_dbm=-90"]) == 2
    assert "radio.noise_dbm=-90.0: run_dir=" in capsys.readouterr().err.splitlines()[-1]
    assert len(driver.calls) == 1
    assert before == {path: path.read_bytes() for path in (tmp_path / "root").rglob("*.yaml")}


def test_an_arms_settings_take_the_place_of_the_configurations():
    config = {"acceptance": "domination", "generations": 7, "rules": {"grammar": "main"}}
    settings = settings_with(config, {"search.acceptance": "ailta", "grammar": "both"})
    assert (settings.search.acceptance, settings.rules.grammar, settings.search.generations) == ("ailta", "both", 7)
    with pytest.raises(InputError, match="omega: no such setting"):
        settings_with(config, {"omega": 1})


def test_the_folder_follows_from_arm_cell_and_seed(tmp_path):
    contributions = experiments()["contributions"]
    config = {"instances": 2, "seed": 8, "environment": "urban", "world": {"buildings": True}}
    found = [one.settings for one in plan(tmp_path, config, contributions, ["no_novelty"])]
    assert [one.run_dir for one in found] == [str(tmp_path / f"ailta/urban_short/seed_200{seed}") for seed in (8, 9)]
    assert [run_folder(tmp_path, one) for one in found] == [tmp_path / f"ailta/urban_short/seed_200{s}" for s in (8, 9)]


def test_experiments_share_their_plain_arm():
    assert {arms[0] for _, arms in reported_experiments().values()} == {"slcs2"}


@pytest.mark.slow
def test_experiments_from_end_to_end(tmp_path):
    """All arms in all eight cells, computed; then more instances, which leaves what is there as it is."""
    sizes = ["generations=2", f"run_dir={tmp_path / 'root'}", *TINY]
    assert cli.main(["experiment", "contributions", "instances=1", *sizes]) == 0
    first = {path: path.read_bytes() for path in tmp_path.rglob("summary.json")}
    assert len(first) == 24
    assert cli.main(["experiment", "contributions", "instances=2", *sizes]) == 0
    assert len(list(tmp_path.rglob("summary.json"))) == 48
    assert cli.main(["experiment", "designed", "instances=2", *sizes]) == 0
    assert len(list(tmp_path.rglob("summary.json"))) == 64
    assert {path: path.read_bytes() for path in first} == first
    text = (tmp_path / "root" / "report" / "report.md").read_text()
    assert text.count("Nothing is missing.") == 2
    for name in ("contributions", "designed"):
        page = (tmp_path / "root" / "report" / f"{name}_report.md").read_text()
        assert "short overall" in page
        assert "long overall" in page
    small = ["instances=1", "generations=1", *TINY, f"run_dir={tmp_path / 'root'}"]
    assert (
        cli.main(["experiment", "calibration", "calibration.only=[swarm.speed]", "calibration.samples=1", *small]) == 0
    )
    rows = (tmp_path / "root" / "calibration" / "calibration.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["tried", "default", "level", "level", "joint"]
