"""Networks of the suite: trained in its train seeds, stopped and gone on with, chosen, deployed; damage is named."""

from __future__ import annotations

import dataclasses
import os
import signal

import numpy as np
import pytest

from slcs2_jax import cli
from slcs2_jax.config import Compute, InputError
from slcs2_jax.learning.worlds import TrainingWorlds
from slcs2_jax.results import Quiet
from slcs2_jax.results.archive import read_archive, write_archive
from slcs2_jax.results.policy_file import FORMAT, load_policy
from slcs2_jax.running.stopping import Stopped
from slcs2_jax.suite import networks
from slcs2_jax.suite.entries import entry_named
from slcs2_jax.suite.frozen import canonical
from slcs2_jax.suite.measured import load
from slcs2_jax.suite.training import plan, read_record, train
from slcs2_jax.suite.worlds import load_suite

TINY = {
    "ippo": "{ippo: {episodes: 6, chunk: 50, unroll: 10, minibatches: 2, stagger: 100}, network: {hidden: [8]}}",
    "recurrent": "{ippo: {episodes: 6, chunk: 50, unroll: 10, minibatches: 2}, network: {hidden: [8], recurrent: 4}}",
    "strategy": "{strategy: {population: 2}, network: {hidden: [4]}}",
}


def entry(folder, name="ippo"):
    """A training of a tiny network with half of the budget."""
    algorithm = "strategy" if name == "strategy" else "ippo"
    file = folder / f"tiny_{name}.yaml"
    file.write_text(f"algorithm: {algorithm}\nbudget: 0.5\nsettings: {TINY[name]}\n")
    return entry_named(str(file))


@pytest.fixture(scope="module")
def trained(tiny, tmp_path_factory):
    """Two trainings in four-agent worlds."""
    root = tmp_path_factory.mktemp("networks")
    trainings = plan(entry(root), [tiny.worlds["few"]], root, compute=Compute())
    train(trainings, Quiet())
    return root, trainings


class Stopping(Quiet):
    """Sends Ctrl-C in the third update."""

    def __init__(self):
        self.calls = 0

    def generation(self, **_):
        self.calls += 1
        if self.calls == 3:
            os.kill(os.getpid(), signal.SIGINT)


def weights(given):
    return given["network"]["out"]["w"]


def test_a_training_spends_its_share_and_keeps_the_fittest_in_the_validation_worlds(trained, tiny):
    root, trainings = trained
    world = tiny.worlds["few"]
    assert [one.settings.seed for one in trainings] == list(world.seeds_of("train"))
    for one in trainings:
        said = read_record(one.record)
        assert said["budget"] == world.env_steps // 2 == 1800
        assert 1800 <= said["env_steps"] < 1800 + 6 * 50
        assert said["episodes"] >= 6
        assert np.shape(said["validation"]) == (len(said["kept_after"]), 2)
        assert said["kept_after"] == sorted(said["kept_after"], reverse=True)
        assert 4 < len(said["kept_after"]) <= 8 + 1
        assert said["chosen"] == int(np.argmax(np.mean(said["validation"], axis=1)))
        held = networks.candidates(root / "runs/tiny_ippo/few" / one.artefact.stem)
        best, kept = said["kept_after"][said["chosen"]], load_policy(one.artefact)
        assert kept.about == {"algorithm": "ippo", "env_steps": best}
        np.testing.assert_array_equal(weights(kept.given), weights(held[best].given))
    first, second = (weights(load_policy(one.artefact).given) for one in trainings)
    assert (first != second).any()


def test_stopped_and_gone_on_with_it_is_the_same_bytes(trained, tiny, tmp_path):
    _, trainings = trained
    again = plan(trainings[0].entry, [tiny.worlds["few"]], tmp_path, compute=Compute(), trainings=1)
    with pytest.raises(Stopped):
        train(again, Stopping())
    assert not again[0].artefact.exists()
    assert train(again, Quiet()) == [again[0].artefact]
    assert again[0].artefact.read_bytes() == trainings[0].artefact.read_bytes()
    assert again[0].record.read_bytes() == trainings[0].record.read_bytes()
    assert train(again, Quiet()) == []


def test_another_budget_is_refused(trained, tiny):
    root, trainings = trained
    other = plan(trainings[0].entry, [tiny.worlds["few"]], root, compute=Compute(), trainings=1, episodes=2)
    assert other[0].budget == 2 * 600
    with pytest.raises(InputError, match=r"training_0\.npz: was trained by another configuration"):
        train(other, Quiet())


def test_its_row_stands_beside_the_others(trained, in_use, monkeypatch, capsys):
    root, trainings = trained
    monkeypatch.chdir(root)
    assert cli.main(["suite", "evaluate", "tiny_ippo.yaml", "world=few", f"run_dir={root}"]) == 0
    assert "> tiny_ippo" in capsys.readouterr().out
    found = load(root, "tiny_ippo", in_use.worlds["few"])
    assert found.steps.shape == (2, 3, 2)
    said = [read_record(one.record) for one in trainings]
    assert found.env_steps == sum(one["env_steps"] + one["validation_env_steps"] for one in said)


@pytest.mark.parametrize("damage", ["cut short", "not finite", "no network", "another version"])
def test_a_damaged_artefact_is_one_line_by_name(trained, in_use, tmp_path, capsys, damage):
    _, trainings = trained
    file = tmp_path / "artefacts/tiny_ippo/few/training_0.npz"
    file.parent.mkdir(parents=True)
    arrays, about = read_archive(trainings[0].artefact, FORMAT)
    if damage == "not finite":
        arrays = {name: leaf * np.float32(np.nan) if leaf.dtype.kind == "f" else leaf for name, leaf in arrays.items()}
    about = {**about, "policy": "other"} if damage == "no network" else about
    write_archive(file, "slcs2_jax policy 0" if damage == "another version" else FORMAT, arrays, about)
    if damage == "cut short":
        file.write_bytes(file.read_bytes()[:-40])
    mine = entry(tmp_path)
    assert mine.trained
    call = ["suite", "evaluate", str(tmp_path / "tiny_ippo.yaml"), "world=few", "trainings=1", f"run_dir={tmp_path}"]
    assert cli.main(call) == 2
    told = capsys.readouterr().err
    assert f"{file}: " in told
    assert told.count("\n") == 1


def test_a_training_that_fails_is_named(trained, tiny):
    root, trainings = trained
    [one] = plan(trainings[0].entry, [tiny.worlds["few"]], root, compute=Compute(), trainings=1)
    said = {**one.changes, "ippo.clip": 0.3}
    named = r"^entry=tiny_ippo, world=few, seed=[0-9]+: .*/checkpoint\.npz: is of another training"
    with pytest.raises(InputError, match=named):
        networks.train(one.entry, one.world, one.settings, one.budget, said, Quiet())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["recurrent", "strategy"])
def test_networks_of_every_kind_are_trained_by_the_command(name, in_use, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    entry(tmp_path, name)
    call = [f"tiny_{name}.yaml", "world=few", "trainings=1", "run_dir=r"]
    assert cli.main(["suite", "train", *call]) == 0
    assert f"artefact r/artefacts/tiny_{name}/few/training_0.npz" in capsys.readouterr().out
    assert cli.main(["suite", "evaluate", *call, "split=validation", "deployments=1"]) == 0
    assert f"> tiny_{name}" in capsys.readouterr().out


def test_a_training_takes_place_in_the_worlds_of_the_train_seeds():
    world = load_suite().worlds["manhattan"]
    few = dataclasses.replace(world, seeds={**world.seeds, "train": (world.seeds["train"][0], 4)})
    places = networks.places(few, few.settings(few.seeds_of("train")[0]))
    assert len(places) == len(few.files["train"]) == 3
    seeds = [seed for _, seeds in places for seed in seeds]
    assert sorted(seeds) == list(few.seeds_of("train"))
    made = [canonical(scenario) for scenario in TrainingWorlds.of(places).scenarios]
    assert made == [canonical(few.scenario(seed)) for seed in seeds]
