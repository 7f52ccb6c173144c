"""Who computes: the native chunk, or XLA, and why."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config.registry import KINDS
from slcs2_jax.native import choice
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.swarm.reward import Progress
from slcs2_jax.swarm.task import Delivery
from slcs2_jax.world.layout import Jammer
from tests.native.episodes import make


class MyReward(Progress):
    """A user's."""


class MyTask(Delivery):
    """A user's."""


class MyPolicy(Classifier):
    """A user's."""


def asked(wanted: str = "auto", platform: str = "cpu", **parts: Any) -> tuple[bool, str | None]:
    episode, parameters = make("open", "main", batch=1)
    physics = parameters.physics
    if "task" in parts:
        parameters = dataclasses.replace(parameters, physics=dataclasses.replace(physics, task=parts["task"]))
    if "policy" in parts:
        parameters = dataclasses.replace(parameters, policy=parts["policy"])
    return choice.choose(wanted, platform, parameters, episode.arena, episode.given)


def test_the_papers_parts_are_native() -> None:
    assert asked() == (True, None)
    assert asked("on") == (True, None)
    assert asked("off") == (False, None)


@pytest.mark.parametrize(
    ("parts", "name"),
    [
        ({"task": Delivery(reward=MyReward())}, "the reward MyReward"),
        ({"task": MyTask()}, "the task MyTask"),
        ({"policy": MyPolicy()}, "the policy MyPolicy"),
    ],
)
def test_a_users_part_is_named(parts: dict[str, Any], name: str) -> None:
    native, line = asked(**parts)
    assert not native
    assert line is not None
    assert name in line
    assert "XLA" in line
    with pytest.raises(InputError, match=rf"compute\.native=on: .*{name}"):
        asked("on", **parts)


@pytest.mark.parametrize("kind", ["emission", "jammer motion"])
def test_a_users_jammer_is_named(kind: str) -> None:
    KINDS[kind].add("mine", len, "my_module")
    try:
        jammer = Jammer(np.zeros(2, np.float32), **{kind.split()[-1]: "mine"})
        episode, parameters = make("open", "main", batch=1, jammers=lambda _: (jammer,))
        assert choice.beyond(parameters, episode.arena, episode.given) == f"the {kind} mine"
    finally:
        KINDS[kind].forget("mine")


def test_on_other_devices_xla_computes() -> None:
    assert asked(platform="gpu") == (False, None)
    with pytest.raises(InputError, match=r"compute\.native"):
        asked("on", platform="gpu")


def test_without_a_library_xla_computes_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "reason_against", lambda: "there is no C++ compiler")
    native, line = asked()
    assert not native
    assert line is not None
    assert line.startswith("there is no C++ compiler; XLA")
    with pytest.raises(InputError, match=r"no C\+\+ compiler; accepted is auto or off"):
        asked("on")
