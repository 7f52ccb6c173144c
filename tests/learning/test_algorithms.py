import dataclasses

import jax
import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.grammar import load_grammar
from slcs2_jax.learning import algorithms
from slcs2_jax.learning.algorithms import kept, settings_of, train
from slcs2_jax.learning.evolution_strategy import Strategy
from slcs2_jax.learning.ippo import Ippo
from slcs2_jax.policy.trained_network import NAME, initial_parameters
from slcs2_jax.results.policy_file import save_policy
from tests.learning.tiny import TRAINED, ippo

TINY = {
    "ippo.episodes": 16,
    "ippo.chunk": 50,
    "ippo.unroll": 10,
    "ippo.minibatches": 4,
    "ippo.discount": 0.99,
    "ippo.learning_rate": 3e-3,
    "ippo.snapshot": 4000,
    "network.hidden": [16],
}


def test_settings_are_given_by_name_and_are_the_defaults_otherwise():
    assert settings_of("ippo", {}) == Ippo()
    assert settings_of("strategy", {}) == Strategy()
    wide = settings_of("strategy", {"strategy.population": 8, "network.recurrent": 5})
    assert (wide.population, wide.network.recurrent, wide.network.sampled) == (8, 5, True)
    assert settings_of("ippo", TINY) == dataclasses.replace(ippo())


@pytest.mark.parametrize(
    ("algorithm", "changes", "message"),
    [
        ("dqn", {}, r"^algorithm=dqn: accepted is one of ippo, strategy$"),
        ("ippo", {"strategy.worlds": 2}, r"^'?strategy.worlds'?: no such setting; accepted are ippo.episodes, "),
        ("ippo", {"ippo.clip": 7}, r"^ippo.clip=7: accepted is a finite number from 0.0001 to 1$"),
        ("ippo", {"network.hidden": []}, r"^network.hidden=\[\]: accepted is a list of 1 to 8 whole numbers"),
    ],
)
def test_what_is_no_setting_is_refused_by_name(algorithm, changes, message):
    with pytest.raises(InputError, match=message):
        settings_of(algorithm, changes)


def test_the_policies_kept_on_the_way_come_back_in_order(tmp_path):
    last = train("ippo", TINY, TRAINED, seed=1, budget_env_steps=9000, folder=tmp_path)
    found = kept(tmp_path)
    steps = [step for step, _ in found]
    assert len(steps) == 3
    assert steps == sorted(steps)
    assert 4000 <= steps[0] < steps[1] <= steps[2]
    np.testing.assert_array_equal(found[-1][1].given["network"]["out"]["w"], last.given["network"]["out"]["w"])
    assert (found[0][1].given["network"]["out"]["w"] != last.given["network"]["out"]["w"]).any()


def network():
    return initial_parameters(load_grammar("main"), np.random.default_rng(0), hidden=(4,))


@pytest.mark.parametrize("env_steps", [None, "7", -1, 1.5, True, 10**30, [1]])
def test_remarks_that_count_nothing_name_their_file(tmp_path, env_steps):
    save_policy(tmp_path / "policy.npz", NAME, network(), {"env_steps": env_steps})
    with pytest.raises(InputError, match=rf"policy={tmp_path}/policy\.npz: env_steps=.*: accepted is a whole number"):
        kept(tmp_path)


def test_parameters_of_no_network_name_their_file(tmp_path):
    save_policy(tmp_path / "policy_000000000007.npz", NAME, network() | {"sampled": np.ones(2)}, {"env_steps": 7})
    with pytest.raises(InputError, match=r"policy=.*policy_000000000007\.npz: policy=network: sampled is neither"):
        kept(tmp_path)


def test_policies_that_take_too_much_together_are_refused(tmp_path, monkeypatch):
    """Each alone is small, and so are their files."""
    monkeypatch.setattr(algorithms, "_MOST_BEYOND", 2**20)
    wide = initial_parameters(load_grammar("main"), np.random.default_rng(0), hidden=(400, 400))
    for number in range(3):
        save_policy(tmp_path / f"policy_{number:012d}.npz", NAME, wide, {"env_steps": number})
    assert [steps for steps, _ in kept(tmp_path)] == [0, 1, 2]
    nothing = jax.tree.map(lambda leaf: np.zeros_like(leaf) if leaf.dtype == np.float32 else leaf, wide)
    for number in range(3):
        save_policy(tmp_path / f"policy_{number:012d}.npz", NAME, nothing, {"env_steps": number})
    with pytest.raises(InputError, match=f"folder={tmp_path}: its policies take gigabytes"):
        kept(tmp_path)


def test_a_network_that_could_not_be_read_again_is_no_setting():
    assert settings_of("ippo", {"network.hidden": [2048, 1024, 1024], "network.recurrent": 512})
    with pytest.raises(InputError, match=r"^network.hidden=\[4096,4096\]: accepted is widths with at most 8,388,608 w"):
        settings_of("ippo", {"network.hidden": [4096, 4096]})
    with pytest.raises(InputError, match="these have 51,122,176"):
        settings_of("ippo", {"network.recurrent": 4096})
