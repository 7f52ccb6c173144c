"""IPPO from one end to the other, in a tiny world."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import slcs2_jax as slcs2
from slcs2_jax.config import InputError, Rules, Settings
from slcs2_jax.learning import ippo as learning
from slcs2_jax.learning.network_settings import NetworkSettings
from slcs2_jax.learning.worlds import TrainingWorlds
from slcs2_jax.policy.bound import bind
from slcs2_jax.results.policy_file import load_policy
from tests.learning.tiny import FRESH, SETTINGS, TRAINED, ippo


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.name != "lock"}


@pytest.mark.parametrize("recurrent", [0, 4])
def test_a_training_that_was_stopped_goes_on_to_the_same_bytes(tmp_path, recurrent):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    settings = ippo(recurrent=recurrent)
    first = learning.train(settings, TRAINED, seed=1, budget_env_steps=9000, folder=whole)
    for budget in (1, 5000, 9000):
        second = learning.train(settings, TRAINED, seed=1, budget_env_steps=budget, folder=parts)
    found = content(whole)
    assert found == content(parts)
    assert {"curve.jsonl", "checkpoint.npz", "policy.npz", "policy_000000004000.npz"} <= set(found)
    np.testing.assert_array_equal(first.given["network"]["out"]["w"], second.given["network"]["out"]["w"])
    curve = [json.loads(line) for line in found["curve.jsonl"].splitlines()]
    assert curve[-2]["env_steps"] < 9000 <= curve[-1]["env_steps"]
    assert sum(line["episodes"] for line in curve) > 0
    saved = load_policy(whole / "policy.npz")
    np.testing.assert_array_equal(saved.given["network"]["out"]["w"], first.given["network"]["out"]["w"])
    assert bind(saved.name, saved.given).policy == first.policy


def test_nothing_changes_once_the_learning_rate_is_0():
    once, longer = (
        learning.train(ippo(anneal=1), TRAINED, seed=1, budget_env_steps=budget).given["network"]
        for budget in (1, 3000)
    )
    np.testing.assert_array_equal(once["out"]["w"], longer["out"]["w"])
    kept = learning.train(ippo(), TRAINED, seed=1, budget_env_steps=3000).given["network"]
    assert (kept["out"]["w"] != longer["out"]["w"]).any()


@pytest.mark.slow
def test_it_learns_to_deliver_sooner():
    settings = ippo()
    start = settings.network.start(SETTINGS, 0)
    trained = learning.train(settings, TRAINED, seed=0, budget_env_steps=60_000)
    before, after = slcs2.Evaluator(SETTINGS)([start, trained], FRESH).mean
    assert after > before + 0.3


def test_another_training_is_not_gone_on_with(tmp_path):
    learning.train(ippo(), TRAINED, seed=1, budget_env_steps=1, folder=tmp_path)
    before = content(tmp_path)
    with pytest.raises(InputError, match=r"is of another training \(seed differ\); accepted is another folder"):
        learning.train(ippo(), TRAINED, seed=2, budget_env_steps=1, folder=tmp_path)
    with pytest.raises(InputError, match=r"\(settings differ\)"):
        learning.train(ippo(clip=0.1), TRAINED, seed=1, budget_env_steps=1, folder=tmp_path)
    (tmp_path / "curve.jsonl").write_text("")
    with pytest.raises(InputError, match=r"has not the 1 whole lines that the checkpoint goes with"):
        learning.train(ippo(), TRAINED, seed=1, budget_env_steps=1, folder=tmp_path)
    (tmp_path / "checkpoint.npz").write_bytes(before["checkpoint.npz"][:-100])
    with pytest.raises(InputError, match=r"checkpoint.npz: no .npz archive, or cut short"):
        learning.train(ippo(), TRAINED, seed=1, budget_env_steps=1, folder=tmp_path)


def test_numbers_that_are_none_are_told_in_a_line_and_not_saved(tmp_path, monkeypatch):
    learning.train(ippo(), TRAINED, seed=1, budget_env_steps=1, folder=tmp_path)
    before = content(tmp_path)
    begun = learning._Training.restore

    def broken(self, tree, counters):
        begun(self, tree, counters)
        self._learner.weights["network"]["out"]["b"] *= np.nan

    monkeypatch.setattr(learning._Training, "restore", broken)
    with pytest.raises(InputError, match=r"^ippo: not finite any more after \d+ env-steps: .*loss.*; accepted is a sm"):
        learning.train(ippo(), TRAINED, seed=1, budget_env_steps=9000, folder=tmp_path)
    assert content(tmp_path) == before


@pytest.mark.parametrize(
    ("changes", "worlds", "message"),
    [
        ({}, [], "worlds=list: accepted is a list of pairs"),
        ({}, [(SETTINGS, [])], "accepted is at least one for each of the settings"),
        ({"chunk": 45, "unroll": 5}, TRAINED, "ippo.chunk=45: accepted is a multiple of swarm.sharing_period=10"),
        ({}, [*TRAINED, (dataclasses.replace(SETTINGS, rules=Rules(grammar="both")), [0])], "different swarms"),
    ],
)
def test_what_cannot_be_trained_is_refused(changes, worlds, message):
    with pytest.raises(InputError, match=message):
        learning.train(ippo(**changes), worlds, seed=0, budget_env_steps=1)


def test_settings_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match=r"ippo.unroll=7: accepted is a divisor of ippo.chunk=50"):
        ippo(unroll=7)
    with pytest.raises(InputError, match=r"network.sampled=false: accepted is true with IPPO"):
        ippo(network=NetworkSettings(sampled=False))


def test_slots_do_not_march_in_step():
    training = learning._Training(ippo(stagger=32), TRAINED, 0, None)
    limits = np.asarray(training._given()[0].time_limit)
    np.testing.assert_array_equal(limits, np.arange(2, 34, 2))  # 16 slots
    training._renew(np.array([3, 5]))
    again = np.asarray(training._given()[0].time_limit)
    assert again[[3, 5]].tolist() == [150, 150]
    np.testing.assert_array_equal(np.delete(again, [3, 5]), np.delete(limits, [3, 5]))
    assert training.playing[3] == 16
    assert training.playing[5] == 17


def test_every_world_comes_once_before_any_comes_again():
    worlds = TrainingWorlds.of([(SETTINGS, range(3)), (SETTINGS, [7])])
    drawn = [worlds.drawn(0, number).seed for number in range(12)]
    assert [sorted(drawn[k : k + 4]) for k in (0, 4, 8)] == [[0, 1, 2, 7]] * 3
    assert drawn != [worlds.drawn(1, number).seed for number in range(12)]
    assert isinstance(worlds.settings, Settings)
