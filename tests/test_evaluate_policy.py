"""slcs2 evaluate with a decision list, from the command to the summary."""

import json

import pytest

from slcs2_jax import cli

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
    assert f"controller: {path}" in config
    assert "move toward source" in config  # the text itself: files change


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["policy=nowhere.txt"], "policy 'nowhere.txt': there is no such policy or file; accepted are"),
        (["policy=designed", "solution=a.npz"], "solution: not together with policy; accepted is one of the"),
        (["policy=designed", "deployments=0"], "deployments=0: accepted is a whole number from 1"),
        ([], "or policy=NAME"),
    ],
)
def test_bad_input_is_one_line(arguments, message, capsys):
    assert cli.main(["evaluate", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
