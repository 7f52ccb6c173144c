"""slcs2 evaluate with a decision list, from the command to the summary."""

import json

import numpy as np
import pytest

from slcs2_jax import cli
from slcs2_jax.config import plugins
from slcs2_jax.config.registry import KINDS
from slcs2_jax.results.policy_file import save_policy

SMALL = [
    "world.distance=200",
    "world.time_limit=400",
    "swarm.agents=3",
    "swarm.packets=4",
    "instances=2",
    "compute.devices=1",
]
CARRY = """\
packet held & node in reach & d_sink < net => send to sink
packet held => move toward sink
no packet held & d_source < net => collect from source
no packet held => move toward source
"""


def test_a_users_behaviour_is_evaluated_and_recorded(tmp_path, capsys):
    path, folder = tmp_path / "carry.txt", tmp_path / "out"
    path.write_text(CARRY)
    assert cli.main(["evaluate", f"policy={path}", *SMALL, "deployments=2", f"run_dir={folder}"]) == 0
    assert "open short, 2 scenarios" in capsys.readouterr().out
    scenarios = json.loads((folder / "summary.json").read_text())["scenarios"]
    assert [one["delivered"] for one in scenarios] == [4, 4]
    assert all(one["fitness"] > 0 for one in scenarios)
    config = (folder / "config.yaml").read_text()
    assert f"policy: {path}" in config
    assert "move toward source" in config  # the text itself: files change


WALK = """
import jax.numpy as jnp
from slcs2_jax.config.registry import register
from slcs2_jax.policy.policy import Policy

@register("policy", "{name}")
class Walk(Policy):
    def initial_memory(self, parameters, agents, learning):
        return ()

    def decide(self, memory, parameters, seen, clock, learning):
        return memory, jnp.zeros(seen.view.x.shape, jnp.int32) + (parameters["action"][0] if parameters else 0)
"""


def test_a_plug_ins_policy_is_evaluated_and_replayed_by_its_name_and_from_a_file(tmp_path, monkeypatch, capsys):
    name = f"slcs2_test_walk_{tmp_path.name}"
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"{name}.py").write_text(WALK.format(name=name))
    save_policy(tmp_path / "walk.npz", name, {"action": np.zeros(1, np.int32)})
    assert cli.main(["evaluate", "policy=walk.npz", *SMALL]) == 2
    assert f"policy={name}: accepted is one of" in capsys.readouterr().err
    try:
        for policy in (name, "walk.npz"):
            assert cli.main(["evaluate", f"policy={policy}", f"plugins=[{name}]", *SMALL]) == 0
            assert "  -1.000 " in capsys.readouterr().out
        replay = ["replay", "policy=walk.npz", f"plugins=[{name}]", *SMALL[:4], "end=20", "picture=paths"]
        assert cli.main(replay) == 0
        assert "walk, open short, seed 0, the first 20 steps" in capsys.readouterr().out
    finally:
        KINDS["policy"].forget(name)
        plugins.forget(name)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["policy=nowhere.txt"], "policy 'nowhere.txt': there is no such policy or file; accepted are"),
        (["policy=designed", "solution=a.npz"], "solution: not together with swarm or policy; accepted is one of "),
        (["policy=designed", "deployments=0"], "deployments=0: accepted is a whole number from 1"),
        ([], "or policy=NAME"),
    ],
)
def test_bad_input_is_one_line(arguments, message, capsys):
    assert cli.main(["evaluate", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
