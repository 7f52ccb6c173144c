"""Whether the native chunk computes a batch, or XLA."""

from __future__ import annotations

from typing import Any

from slcs2_jax import runtime
from slcs2_jax.config import Compute
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse
from slcs2_jax.config.registry import KINDS
from slcs2_jax.episode import Parameters
from slcs2_jax.native.arrays import FADINGS, POLICIES
from slcs2_jax.native.library import reason_against
from slcs2_jax.policy.rules import Rules
from slcs2_jax.swarm.reward import Progress
from slcs2_jax.swarm.task import Delivery
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.propagation import LogDistance


def beyond(parameters: Parameters, arena: Arena, given: Any) -> str | None:
    """Which part of a batch the native chunk does not know, in words; None if it knows all of it."""
    physics = parameters.physics
    language, task, radio = physics.language, physics.task, physics.radio
    if type(parameters.policy) not in POLICIES or type(given) is not Rules:
        return f"the policy {type(parameters.policy).__name__}"
    if language.own_clauses or language.own_actions:
        return "a clause or an action of a plug-in"
    if type(task) is not Delivery:
        return f"the task {type(task).__name__}"
    if type(task.reward) is not Progress:
        return f"the reward {type(task.reward).__name__}"
    if type(radio.propagation) is not LogDistance:
        return f"the propagation {type(radio.propagation).__name__}"
    if type(radio.fading) not in FADINGS:
        return f"the fading {type(radio.fading).__name__}"
    if arena.emitters is not None:
        for kind, names in (("emission", arena.emitters.emissions), ("jammer motion", arena.emitters.motions)):
            for name in names:
                if KINDS[kind].home(name) is not None:
                    return f"the {kind} {name}"
    return None


def expected(compute: Compute) -> bool:
    """Whether the native chunk computes whatever batch has no parts that it does not know."""
    return compute.native != "off" and runtime.devices(compute)[0].platform == "cpu" and reason_against() is None


def computed_on(compute: Compute) -> str:
    """In words, the devices and what computes on them, as a run records it: `2 x cpu (cpu), native chunk`.

    Both decide the last bits of a run. Parts that the native chunk does not know are among the settings that a run has.
    """
    return f"{runtime.describe_devices(compute)}, {'native chunk' if expected(compute) else 'XLA'}"


def choose(wanted: str, platform: str, parameters: Parameters, arena: Arena, given: Any) -> tuple[bool, str | None]:
    """Whether the native chunk computes a batch, and a line to tell if XLA does although nobody said so.

    Args:
        wanted: ``compute.native``, auto, on or off.
        platform: of the devices.
        parameters, arena, given: of the batch.

    Raises:
        InputError: it is wanted, and impossible.
    """
    if wanted == "off":
        return False, None
    if platform != "cpu":
        if wanted == "on":
            raise refuse("compute.native", wanted, f"auto or off on {platform} devices")
        return False, None
    part = beyond(parameters, arena, given)
    reason = f"the native chunk does not know {part}" if part else reason_against()
    if reason is None:
        return True, None
    if wanted == "on":
        raise InputError(f"compute.native=on: {reason}; accepted is auto or off")
    return False, f"{reason}; XLA computes instead, several times slower"
