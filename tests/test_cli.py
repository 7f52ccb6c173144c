"""The console command: what it prints, what it hands to the driver, and one line for any bad input."""

import os
import shlex
import subprocess
import sys
import types

import numpy as np
import pytest

from slcs2_jax import __version__, cli, runtime
from slcs2_jax.config import Rules, Search, Settings, Swarm, World, plugins, settings_table
from slcs2_jax.config.registry import KINDS
from slcs2_jax.grammar import RuleSets, load_grammar, random_rules
from slcs2_jax.results import (
    EvaluationSummary,
    InstanceSummary,
    RunFolder,
    RunSummary,
    SavedSolution,
    ScenarioSummary,
    read_run,
)
from slcs2_jax.results.sweep import runs_below


class Driver(types.ModuleType):
    """Stands in for running/driver.py: keeps what it was called with."""

    def __init__(self) -> None:
        super().__init__("slcs2_jax.running.driver")
        self.evolved: list[list[Settings]] = []
        self.evaluated: list[tuple[Settings, SavedSolution, int]] = []

    def evolve(self, settings, *, report, as_begun=False):
        self.evolved.append(list(settings))
        summaries = []
        for run in settings:
            begun(run)
            report.generation(done=[1] * run.instances, best=[0.5] * run.instances, evaluations=1, env_steps=9)
            instance = InstanceSummary(
                seed=0, generations=1, best_fitness=0.5, fresh_mean=0.4, fresh_sd=0.1, evaluations=1, env_steps=9
            )
            summaries.append(
                RunSummary(
                    run_dir=run.run_dir,
                    generations=1,
                    instances=(instance,),
                    wall_seconds=1.0,
                    env_steps_per_second=9.0,
                    host_share=0.012,
                    useful_share=0.93,
                )
            )
        return summaries

    def evaluate(self, settings, solution, *, deployments, report):
        self.evaluated.append((settings, solution, deployments))
        one = ScenarioSummary(seed=0, fitness=0.25, fitness_sd=0.1, delivered=3.0, steps=9.0, deployments=deployments)
        return EvaluationSummary(scenarios=(one,), wall_seconds=1.0, env_steps_per_second=9.0)


@pytest.fixture
def driver(monkeypatch, tmp_path):
    import slcs2_jax.running

    stub = Driver()
    monkeypatch.setitem(sys.modules, stub.__name__, stub)
    monkeypatch.setattr(slcs2_jax.running, "driver", stub, raising=False)
    monkeypatch.setattr(runtime, "configure", lambda compute: None)
    monkeypatch.chdir(tmp_path)
    return stub


@pytest.fixture
def saved(tmp_path):
    grammar = load_grammar("main")
    mask, action = random_rules(grammar, 6, np.random.default_rng(0))
    zeros = np.zeros((2, 3), np.float32)
    solution = SavedSolution(
        rules=RuleSets(mask.reshape(2, 3, 4), action.reshape(2, 3)),
        quality=zeros,
        strength=zeros,
        error=zeros,
        usage=zeros.astype(np.int32),
        contribution=zeros[:, 0],
        settings=Settings(world=World.preset("urban"), swarm=Swarm(agents=2, speed=1.5), rules=Rules(rules=3)),
        grammar_text=grammar.text,
        instance_seed=0,
        generation=0,
        fitness=-1.0,
        deployments=1,
    )
    path = tmp_path / "saved.npz"
    solution.save(path)
    return path


def begun(settings: Settings) -> None:
    """Leave the folder of a run that was interrupted at once."""
    folder = RunFolder.open(
        settings, device="test", texts=lambda: {"grammar.bnf": load_grammar("main").text}, record={}
    )
    folder.close()


def refused(capfd, *arguments: str) -> str:
    """The one line on stderr of a command that ends with code 2 and prints nothing else."""
    assert cli.main(arguments) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("slcs2: error: ")
    assert err.count("\n") == 1
    return err


BAD = [
    (["dance"], "command=dance: accepted is one of evolve, resume"),
    (["evolve", "--frobnicate"], "option=--frobnicate: accepted is one of -m"),
    (["evolve", "--cfg"], "option --cfg: accepted is --cfg VALUE"),
    (["evolve", "--cfg", "all of it"], "option --cfg=all of it: accepted is one of job, hydra, all"),
    (["evolve", "-m", "--cfg", "job"], "not together with -m"),
    (["evolve", "environment=forest"], "environment=forest: accepted is one of jammed, open, urban, urban_jammed"),
    (["evolve", "wings=2"], "wings: no such setting"),
    (["evolve", "radio.noise=2"], "radio.noise: no such setting; did you mean radio.noise_dbm"),
    (["evolve", "seed"], "seed: accepted is an override of the form setting=value"),
    (["evolve", "generations=many"], "generations=many: accepted is a whole number from 1"),
    (["evolve", "generations=-5"], "generations=-5: accepted is a whole number from 1"),
    (["evolve", "generations=2.5"], "generations=2.5: accepted is a whole number from 1"),
    (["evolve", "swarm.agents=1"], "swarm.agents=1: accepted is a whole number from 2 to 64"),
    (["evolve", "swarm.speed=-2"], "swarm.speed=-2: accepted is a finite number from 0.0001 to 1000"),
    (["evolve", "radio.noise_dbm=nan"], "radio.noise_dbm=nan: accepted is a finite number"),
    (["evolve", "radio.noise_dbm=inf"], "radio.noise_dbm=inf: accepted is a finite number"),
    (["evolve", "radio=[1,2]"], "radio=[1,2]: accepted is a setting of it"),
    (["evolve", "environment=null"], "environment=null: accepted is one of jammed, open"),
    (["evolve", "environment={a:1}"], "environment={a:1}: accepted is one of jammed, open"),
    (["evolve", "~radio"], "~radio: accepted is setting=value"),
    (["evolve", "+environment=urban"], "environment"),
    (["evolve", "hydra.mode=NONE"], "hydra.mode=NONE"),
    (["evolve", "-m", "hydra.sweeper.max_batch_size=x", "seed=1,2"], "x"),
    (["evolve", "environment=jammed", "world.distance=300"], "no place for the jammer"),
    (["evolve", "swarm.agents=60", "world.start_radius=3"], "no place for the agents"),
    (["evolve", "grammar=nowhere.bnf"], "nowhere.bnf"),
    (["evolve", "grammar=broken.bnf"], "broken.bnf"),
    (["evolve", "rules.codons=0"], "rules.codons=0: accepted is a whole number from 1 to 1024"),
    (["evolve", "run_dir=taken", "seed=5"], "seed=5: run_dir=taken already holds a run with seed=0"),
    (["evolve", "run_dir=taken", "generations=5"], "generations=5: run_dir=taken already holds a run with"),
    (["evolve", "run_dir=taken", "radio.noise_dbm=-90"], "radio.noise_dbm=-90.0: run_dir=taken already holds"),
    (["evolve", "run_dir=evaluated"], "run_dir=evaluated: already holds an evaluation"),
    (["resume"], "resume: accepted is slcs2 resume FOLDER"),
    (["resume", "nowhere"], "folder=nowhere: no such folder"),
    (["resume", "empty"], "folder=empty: holds no run"),
    (["resume", "taken", "seed=5"], "setting=seed: accepted is one of generations, compute.devices"),
    (["resume", "taken", "generations=many"], "generations=many: accepted is a whole number"),
    (["resume", "taken", "generations=[1"], "generations=[1: accepted is a number"),
    (["resume", "taken", "generations=5"], "generations=5: run_dir=taken already holds a run with generations=500"),
    (["evolve", "run_dir=broken.bnf/below"], "broken.bnf is a file"),
    (["evolve", "seed=1,2"], "seed=1,2: accepted is one value; add -m"),
    (["evolve", "-m", "seed=1,1"], "a folder of its own for every run"),
    (["evolve", "-m", "compute.chunk=10,20"], "compute: differs between the runs"),
    (["evolve", "-m", "swarm.agents=12,1"], "swarm.agents=1: accepted"),
    (["evolve", "-m", "swarm.agents=12,1", "hydra/launcher=basic"], "swarm.agents=1: accepted"),
    (["evaluate"], "solution: has no default"),
    (["evaluate", "solution=nowhere.npz"], "nowhere.npz: no such file"),
    (["evaluate", "solution=broken.bnf"], "broken.bnf: not a solution saved by slcs2"),
    (["evaluate", "solution=saved.npz", "deployments=0"], "deployments=0: accepted is a whole number from 1"),
    (["evaluate", "solution=saved.npz", "swarm.agents=12"], "swarm.agents=12: accepted is 2, as the solution has it"),
    (["evaluate", "solution=saved.npz", "grammar=both"], "grammar=both: accepted is main"),
    (["evaluate", "solution=saved.npz", "generations=3"], "generations"),
    (["evaluate", "-m", "solution=saved.npz"], "option -m: not for evaluate"),
]


@pytest.mark.parametrize(("arguments", "part"), BAD)
def test_bad_input_is_one_line_and_nothing_is_run_or_written(arguments, part, driver, saved, tmp_path, capfd):
    (tmp_path / "broken.bnf").write_text("<rule> ::= <rule> <rule>\n")
    begun(Settings(run_dir="taken"))
    RunFolder.create(Settings(run_dir="evaluated"), device="test")
    (tmp_path / "empty").mkdir()
    before = sorted((p, p.read_bytes() if p.is_file() else b"") for p in tmp_path.rglob("*"))
    assert part in refused(capfd, *arguments)
    assert (driver.evolved, driver.evaluated) == ([], [])
    assert sorted((p, p.read_bytes() if p.is_file() else b"") for p in tmp_path.rglob("*")) == before


def test_evolve_hands_the_settings_to_the_driver(driver, capfd):
    assert cli.main(["evolve", "environment=urban", "range=long", "generations=3", "run_dir=here"]) == 0
    [[settings]] = driver.evolved
    assert settings.world == World.preset("urban", "long")
    assert (settings.search.generations, settings.run_dir) == (3, "here")
    out, err = capfd.readouterr()
    assert "run folder here" in out
    assert out.endswith("1.0 s, 9 env-steps/s, useful slot-steps 93%, host 1.2%\n")
    assert "generation 1/3" in err
    assert read_run("here").settings == settings


def test_the_run_folder_is_named_by_what_is_run(driver, tmp_path):
    assert cli.main(["evolve", "environment=jammed", "seed=4"]) == 0
    [folder] = (tmp_path / "runs").iterdir()
    assert folder.name.endswith("_jammed_short_main_s4")
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]


def test_a_sweep_is_one_call(driver, tmp_path):
    assert cli.main(["evolve", "-m", "environment=open,urban", "range=short,long", "run_dir=all"]) == 0
    [settings] = driver.evolved
    assert len(settings) == 4
    assert sorted(p.name for p in (tmp_path / "all").iterdir()) == [
        "open_long",
        "open_short",
        "sweep.json",
        "urban_long",
        "urban_short",
    ]


def test_an_option_may_stand_anywhere(driver):
    assert cli.main(["evolve", "seed=1,2", "-m", "generations=3"]) == 0
    [settings] = driver.evolved
    assert [run.seed for run in settings] == [1, 2]


def test_another_launcher_is_many_calls(driver):
    assert cli.main(["evolve", "-m", "seed=1,2", "hydra/launcher=basic", "run_dir=all"]) == 0
    assert [[run.seed for run in settings] for settings in driver.evolved] == [[1], [2]]
    settings, _ = runs_below("all")
    assert [run.run_dir for run in settings] == ["all/s1", "all/s2"]


def test_a_sweep_into_the_folder_of_another_runs_nothing(driver, capfd):
    begun(Settings(run_dir="all/s2", seed=7))
    assert "run_dir=all/s2 already holds a run with seed=7" in refused(capfd, "evolve", "-m", "seed=1,2", "run_dir=all")
    assert driver.evolved == []


def test_a_sweep_goes_on_with_the_runs_it_began(driver):
    begun(Settings(run_dir="all/s2", seed=2))
    assert cli.main(["evolve", "-m", "seed=1,2", "run_dir=all"]) == 0
    assert [[run.seed for run in settings] for settings in driver.evolved] == [[1, 2]]


def test_resume_takes_every_run_of_a_sweep_even_those_that_had_not_begun(driver, monkeypatch):
    def interrupt(settings, **_):
        raise KeyboardInterrupt

    evolve = driver.evolve
    monkeypatch.setattr(driver, "evolve", interrupt)
    assert cli.main(["evolve", "-m", "seed=1,2,3", "generations=9", "run_dir=all"]) == 130
    begun(Settings(run_dir="all/s2", seed=2, search=Search(generations=9)))
    monkeypatch.setattr(driver, "evolve", evolve)
    assert cli.main(["resume", "all", "generations=600"]) == 0
    [settings] = driver.evolved
    assert [(run.seed, run.search.generations, run.run_dir) for run in settings] == [
        (seed, 600, f"all/s{seed}") for seed in (1, 2, 3)
    ]


def test_paths_may_hold_any_letter(driver, saved, tmp_path):
    odd = tmp_path / "it's (a=b), [c] {d}:e ;#\\f" / "saved.npz"
    odd.parent.mkdir()
    saved.rename(odd)
    assert cli.main(["evaluate", f"solution={odd}", f"run_dir={odd.parent / 'new one'}"]) == 0
    assert (odd.parent / "new one" / "summary.json").exists()


def test_a_bug_is_no_input_error(driver, monkeypatch):
    def fail(settings, **_):
        raise ZeroDivisionError

    monkeypatch.setattr(driver, "evolve", fail)
    for arguments in ([], ["-m", "seed=1,2"], ["-m", "seed=1,2", "hydra/launcher=basic"]):
        with pytest.raises(ZeroDivisionError):
            cli.main(["evolve", *arguments])


def test_evaluate(driver, saved, capfd):
    assert cli.main(["evaluate", f"solution={saved}", "environment=open", "instances=5", "run_dir=again"]) == 0
    [(settings, solution, deployments)] = driver.evaluated
    assert settings.world == World.preset("open")
    assert (settings.swarm.speed, settings.instances, deployments) == (1.5, 5, 1)
    assert solution.agents == 2
    assert "0.250" in capfd.readouterr().out
    assert read_run("again").summary["fitness_mean"] == 0.25


def test_an_interruption_is_one_line(driver, monkeypatch, capfd):
    def interrupt(settings, **_):
        raise KeyboardInterrupt

    monkeypatch.setattr(driver, "evolve", interrupt)
    assert cli.main(["evolve"]) == 130
    assert capfd.readouterr().err == "slcs2: interrupted; what was saved before is intact\n"


def test_a_disk_that_refuses_is_one_line(driver, monkeypatch, capfd):
    from slcs2_jax.config import StorageError

    def fail(settings, **_):
        raise StorageError("run/summary.json: cannot be written (No space left on device)")

    monkeypatch.setattr(driver, "evolve", fail)
    assert cli.main(["evolve"]) == 1
    err = capfd.readouterr().err
    assert err == "slcs2: error: run/summary.json: cannot be written (No space left on device)\n"


def test_an_input_error_from_below_is_one_line(driver, monkeypatch, capfd):
    def refuse(settings, **_):
        from slcs2_jax.config import InputError

        raise InputError("world: no place\nfor the walls")

    monkeypatch.setattr(driver, "evolve", refuse)
    assert refused(capfd, "evolve") == "slcs2: error: world: no place for the walls\n"


@pytest.mark.parametrize("arguments", [["--cfg", "job", "seed=9"], ["seed=9", "--cfg", "job"]])
def test_the_composed_configuration_can_be_shown(arguments, driver, capfd):
    assert cli.main(["evolve", *arguments]) == 0
    assert "seed: 9" in capfd.readouterr().out
    assert driver.evolved == []


@pytest.mark.parametrize("arguments", [[], ["--help"], ["evolve", "--help"], ["evaluate", "-h"]])
def test_help_explains_every_setting(arguments, capsys):
    assert cli.main(arguments) == 0
    shown = capsys.readouterr().out
    for row in settings_table():
        assert f"{row.name}={row.value}" in shown
        assert row.help in shown


def test_version(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"slcs2 {__version__}\n"


def command(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=60, **options)


def test_help_starts_neither_jax_nor_hydra(tmp_path):
    code = (
        "import sys, slcs2_jax.cli as c; c.main(['--help']); print([m for m in ('jax', 'hydra') if m in sys.modules])"
    )
    shown = command("-c", code, cwd=tmp_path, env=environment()).stdout
    assert shown.endswith("[]\n")


def test_bad_input_does_not_start_jax(tmp_path):
    code = "import sys, slcs2_jax.cli as c; print(c.main(['evolve', 'swarm.agents=1']), 'jax' in sys.modules)"
    assert command("-c", code, cwd=tmp_path, env=environment()).stdout == "2 False\n"


def test_as_a_module(tmp_path):
    done = command("-m", "slcs2_jax", "evolve", "seed=-1", cwd=tmp_path, env=environment())
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "slcs2: error: seed=-1: accepted is a whole number from 0 to 2147483647\n"


@pytest.mark.parametrize(
    "typed",
    [
        ["evolve", "seed=3", "run_dir=it's here/a b"],
        ["evolve", "-m", "seed=1,2", "environment=open,urban", "run_dir=all"],
        ["evolve", "-m", "seed=1,2", "hydra/launcher=basic", "run_dir=all"],
        ["evolve", "run_dir=here", "--config-dir", "my groups", "radio=mine"],
    ],
)
def test_a_recorded_command_can_be_pasted(typed, driver, tmp_path):
    (tmp_path / "my groups" / "radio").mkdir(parents=True)
    (tmp_path / "my groups" / "radio" / "mine.yaml").write_text("noise_dbm: -90.0\n")
    assert cli.main(typed) == 0
    first, driver.evolved = driver.evolved, []
    for run in first[0]:
        name, *again = shlex.split(read_run(run.run_dir).record["command"])
        assert name == "slcs2"
        assert cli.main(again) == 0
        assert driver.evolved == first
        driver.evolved = []


PLUGIN = """
from slcs2_jax.config.registry import register


@register("search", "{name}")
class Mine:
    pass
"""


@pytest.fixture
def plugin(tmp_path):
    """A module in the current folder that brings a search; its name is the module's."""
    name = f"slcs2_test_cli_plugin_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(PLUGIN.format(name=name))
    yield name
    plugins.forget(name)
    KINDS["search"].forget(name)
    sys.modules.pop(name, None)


def test_a_plug_in_is_named_recorded_and_asked_for_again(driver, plugin, tmp_path, capfd):
    assert "accepted is one of slcs2, random" in refused(capfd, "evolve", f"search={plugin}")
    assert cli.main(["evolve", f"search={plugin}", f"plugins=[{plugin}]", "run_dir=mine"]) == 0
    [[settings]] = driver.evolved
    assert (settings.search.name, settings.plugins) == (plugin, (plugin,))
    capfd.readouterr()

    # as in a new process: the folder alone brings nothing in
    plugins.forget(plugin)
    KINDS["search"].forget(plugin)
    sys.modules.pop(plugin)
    for command in (["resume", "mine"], ["repeat", "mine"], ["report", "mine"], ["watch", "mine", "once=on"],
                    ["replay", "mine"], ["rules", "mine"]):  # fmt: skip
        line = refused(capfd, *command)
        assert f"needs the plug-in {plugin}" in line
        assert f"accepted is plugins=[{plugin}], if you trust it" in line
    assert plugin not in sys.modules
    assert cli.main(["resume", "mine", f"plugins=[{plugin}]", "generations=501"]) == 0
    assert driver.evolved[1][0].plugins == (plugin,)
    capfd.readouterr()

    sys.modules.pop(plugin)
    with (tmp_path / f"{plugin}.py").open("a") as file:
        file.write("# changed\n")
    assert "has changed since" in refused(capfd, "resume", "mine", f"plugins=[{plugin}]")


def test_a_plug_in_that_a_group_names_is_not_imported(driver, plugin, tmp_path, capfd):
    (tmp_path / "groups" / "radio").mkdir(parents=True)
    (tmp_path / "groups" / "radio" / "theirs.yaml").write_text(f"# @package _global_\nplugins: [{plugin}]\n")
    line = refused(capfd, "evolve", "--config-dir", "groups", "radio=theirs")
    assert f"needs the plug-in {plugin}" in line
    assert plugin not in sys.modules


def environment() -> dict[str, str]:
    """Finds the package from any folder, installed or not."""
    root = os.path.dirname(os.path.dirname(os.path.abspath(cli.__file__)))
    return os.environ | {"PYTHONPATH": root}
