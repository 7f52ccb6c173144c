"""Live logging: every logger is told the same, none changes a byte of results, none can stop a run."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import sqlite3
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from slcs2_jax import cli
from slcs2_jax.config import Compute, InputError, Rules, Search, Settings, Swarm, World
from slcs2_jax.config.registry import KINDS, register
from slcs2_jax.results import loggers, read_run
from slcs2_jax.running import driver

ROW = {"instance": 0, "seed": 3, "generation": 0, "fitness": 0.5, "accepted": True, "novelty": None, "crew": (1.0,)}
SUMMARY = {"generations": 1, "instances": [{"seed": 3, "generations": 1, "fresh_mean": 0.25}]}


def settings(run_dir: Path | None, **values) -> Settings:
    """A small run."""
    return Settings(
        world=World(distance=190.0, time_limit=200),
        swarm=Swarm(agents=3, packets=4),
        rules=Rules(rules=10),
        search=Search(generations=2, fresh_deployments=2),
        compute=Compute(devices=1, chunk=50),
        run_dir=None if run_dir is None else str(run_dir),
        **{"instances": 2, **values},
    )


def results(folder: Path) -> dict[str, bytes]:
    """All that a run came to."""
    names = [
        "generations.jsonl",
        "summary.json",
        *(f"solutions/{path.name}" for path in (folder / "solutions").iterdir()),
    ]
    return {name: (folder / name).read_bytes() for name in names}


@pytest.fixture
def deaf():
    """Loggers of this test: one that keeps what it is told, one that fails at the second generation."""
    told: list = []

    @register("logger", "keeps")
    class Keeps(loggers.Nobody):
        def generation(self, row):
            told.append(row)

        def summary(self, summary):
            told.append(summary)

        def close(self):
            told.append("closed")

    @register("logger", "breaks")
    class Breaks(Keeps):
        def generation(self, row):
            if row["generation"] == 1:
                raise RuntimeError("no\nline")

    yield told
    for name in ("keeps", "breaks"):
        KINDS["logger"].forget(name)


class Notes:
    """A report that keeps its notes."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def generation(self, **values) -> None: ...
    def note(self, text: str) -> None:
        self.notes.append(text)


def test_nobody_changes_a_byte_and_a_broken_one_is_let_go(tmp_path, deaf):
    report = Notes()
    names = ("none", "jsonl", "tensorboard", "keeps", "breaks")
    driver.evolve([settings(tmp_path / name, logger=name) for name in names], report=report)
    plain = results(tmp_path / "none")
    for name in names[1:]:
        assert results(tmp_path / name) == plain, name
    rows = read_run(tmp_path / "none").rows
    lines = [json.loads(line) for line in (tmp_path / "jsonl" / "log.jsonl").read_text().splitlines()]
    assert all(line.pop("time") > 1.7e9 for line in lines)
    said = json.loads((tmp_path / "none" / "summary.json").read_text())
    assert [line["summary"]["instances"] for line in lines if "summary" in line] == [said["instances"]]

    def order(row):
        return row["generation"], row["instance"]

    assert sorted((line for line in lines if "summary" not in line), key=order) == sorted(rows, key=order)
    kept = [one for one in deaf if one != "closed"]
    assert len([one for one in kept if "fitness" in one]) == len(rows)
    assert deaf.count("closed") == 1, "the broken one is not told that it is over"
    [note] = [note for note in report.notes if "logger" in note]
    assert note.startswith("logger=breaks failed and is told no more (RuntimeError: no")
    assert "\n" not in note


def test_what_a_folder_says_is_told_to_nobody_unless_it_is_named_again(tmp_path, deaf, capsys):
    driver.evolve([settings(tmp_path / "run", logger="keeps")])
    del deaf[:]
    assert cli.main(["resume", str(tmp_path / "run"), "generations=3"]) == 0
    assert deaf == []
    assert cli.main(["repeat", str(tmp_path / "run")]) == 0
    assert deaf == []
    assert cli.main(["resume", str(tmp_path / "run"), "generations=4", "logger=jsonl"]) == 0
    told = [json.loads(line) for line in (tmp_path / "run" / "log.jsonl").read_text().splitlines()]
    assert [line["generation"] for line in told if "generation" in line] == [3, 3]
    capsys.readouterr()


@pytest.mark.parametrize("name", ["tensorboard", "wandb", "trackio"])
def test_a_missing_package_is_one_line_that_names_the_extra(name, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, name, None)
    assert cli.main(["evolve", f"logger={name}", f"run_dir={tmp_path / 'run'}"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"logger={name}: {name} is not installed; accepted is an installation with slcs2_jax[{name}]" in said
    assert not (tmp_path / "run").exists()


def test_other_impossible_ones_are_refused(tmp_path, deaf, capsys):
    with pytest.raises(InputError, match=r"logger=jsonl: writes into the run folder, and run_dir is null"):
        driver.evolve([settings(None, logger="jsonl")])
    assert cli.main(["evolve", "logger=telegraph"]) == 2
    assert "logger=telegraph: accepted is one of none, jsonl, tensorboard, wandb, trackio" in capsys.readouterr().err

    @register("logger", "breaks")
    class Never(loggers.Nobody):
        def __init__(self, settings):
            raise OSError("no network")

    with pytest.raises(InputError, match=r"logger=breaks: did not start \(OSError: no network\)"):
        driver.evolve([settings(tmp_path / "run", logger="breaks")])


def test_a_link_in_the_folder_leads_nowhere(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "run" / "tensorboard").symlink_to(tmp_path / "elsewhere")
    told = loggers.Told(dataclasses.replace(settings(tmp_path / "run"), logger="tensorboard"))
    with pytest.raises(InputError, match="logger=tensorboard: did not start"):
        told.start()
    assert not list((tmp_path / "elsewhere").iterdir())


def tell(name: str, folder: Path) -> None:
    """A row and a summary."""
    folder.mkdir()
    told = loggers.Told(dataclasses.replace(settings(folder), logger=name))
    told.start()
    told.generation(ROW)
    told.generation({**ROW, "generation": 1, "fitness": float("nan")})
    told.summary(SUMMARY)
    told.close()


def test_tensorboard_reads_what_it_was_told(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    tell("tensorboard", tmp_path / "run")
    found = EventAccumulator(str(tmp_path / "run" / "tensorboard")).Reload()
    curves = {tag: [(event.step, event.tensor_proto.float_val[0]) for event in found.Tensors(tag)]
              for tag in found.Tags()["tensors"]}  # fmt: skip
    assert curves == {
        "seed_003/fitness": [(0, 0.5)],
        "seed_003/accepted": [(0, 1.0), (1, 1.0)],
        "seed_003/fresh_mean": [(1, 0.25)],
    }


class Stand:
    """Stands in for a run of wandb or of trackio and keeps what it is told."""

    def __init__(self) -> None:
        self.told: list = []
        self.summary: dict = {}

    def log(self, values, step=None):
        self.told.append((step, values))

    def define_metric(self, name, step_metric):
        self.told.append((name, step_metric))

    def finish(self):
        self.told.append("finished")


@pytest.mark.parametrize("name", ["wandb", "trackio"])
def test_services_are_told_by_their_own_interface(name, tmp_path, monkeypatch):
    run, asked = Stand(), {}
    service = SimpleNamespace(init=lambda **values: asked.update(values) or run, Settings=lambda **values: values)
    monkeypatch.setitem(sys.modules, name, service)
    tell(name, tmp_path / "run")
    assert (asked["project"], asked["name"]) == ("slcs2_jax", "run")
    assert asked["config"]["swarm"]["agents"] == 3
    assert run.told.pop() == "finished"
    figures = {"seed_003/fitness": 0.5, "seed_003/accepted": 1.0}
    if name == "wandb":
        assert asked["reinit"] == "create_new"
        assert run.told[0] == ("seed_003/*", "seed_003/generation")
        assert run.told[1] == (None, {"seed_003/generation": 0, **figures})
        assert run.summary == {"seed_003/fresh_mean": 0.25}
    else:
        assert run.told[0] == (0, figures)
        assert run.told[-1] == (1, {"seed_003/fresh_mean": 0.25})


OFFLINE = """
from pathlib import Path
from tests.results.test_loggers import tell
tell({name!r}, Path({folder!r}))
"""


@pytest.mark.slow
def test_services_that_are_installed_keep_it_offline(tmp_path, monkeypatch):
    """The session `loggers` of noxfile.py has both."""
    monkeypatch.setenv("WANDB_MODE", "offline")
    monkeypatch.setenv("TRACKIO_DIR", str(tmp_path / "trackio"))
    for name in [name for name in ("wandb", "trackio") if importlib.util.find_spec(name)]:
        code = OFFLINE.format(name=name, folder=str(tmp_path / name))
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        if name == "wandb":
            [file] = (tmp_path / name / "wandb").glob("offline-run-*/*.wandb")
            assert b"seed_003/fitness" in file.read_bytes()
            continue
        with sqlite3.connect(tmp_path / "trackio" / "slcs2_jax.db") as database:
            found = database.execute("select run_name, step, metrics from metrics order by id").fetchall()
        assert found[0][:2] == (name, 0)
        assert json.loads(found[0][2])["seed_003/fitness"] == 0.5
