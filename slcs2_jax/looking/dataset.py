"""A recorded episode as an xarray Dataset."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.swarm.fate import Fate

if TYPE_CHECKING:
    import xarray

    from slcs2_jax.looking.recording import Recording

# Dimensions, unit and meaning of each variable; the arrays are those of the recording.
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "x": (("moment", "agent"), "m", "place of the agent; the source is the origin"),
    "y": (("moment", "agent"), "m", "place of the agent; the source is the origin"),
    "holding": (("moment", "agent"), "", "holds a packet"),
    "down": (("moment", "agent"), "", "has failed, and does not work in the step from this moment on"),
    "waiting": (("moment",), "packets", "at the source"),
    "delivered": (("moment",), "packets", "at the sink"),
    "jammer_x": (("moment", "jammer"), "m", "place of the jammer"),
    "jammer_y": (("moment", "jammer"), "m", "place of the jammer"),
    "jammed": (("step", "jammer"), "", "index of the channel that the jammer emitted on; -1 for none"),
    "action": (("step", "agent"), "", "number of the action; 255 for none"),
    "rule": (("step", "agent"), "", "number of the rule that was drawn; -1 for none"),
    "sent_to": (("step", "agent"), "", "node that a packet was sent to: agents, then source and sink; -1 for none"),
    "sent_fate": (("step", "agent"), "", "what became of it; the numbers stand in the attribute fates"),
    "served": (("step", "channel"), "", "agent that the source sent a packet to; -1 for none"),
    "served_fate": (("step", "channel"), "", "what became of it"),
    "matched": (("agent", "own_rule"), "steps", "in which the rule's condition held"),
    "usage": (("agent", "own_rule"), "steps", "in which the rule was in the action set"),
    "quality": (("agent", "own_rule"), "", "at the end"),
    "strength": (("agent", "own_rule"), "", "at the end"),
    "error": (("agent", "own_rule"), "", "at the end"),
    "contribution": (("agent",), "packets", "delivered that the agent had held"),
}


def to_dataset(recording: Recording) -> xarray.Dataset:
    """The recording as a Dataset: T steps, T + 1 moments, agents, channels in use, the agents' own rules.

    `heard` [step, node, agent] tells who heard whom; nodes are the agents, the source and the sink.

    Raises:
        InputError: xarray is not installed.
    """
    try:
        import xarray
    except ImportError:
        raise InputError(
            "to_xarray: xarray is not installed; accepted is an installation with slcs2_jax[data]"
        ) from None
    known = {field.name for field in dataclasses.fields(recording)}
    variables: dict[str, Any] = {}
    for name, (dimensions, unit, meaning) in VARIABLES.items():
        if name in known:
            attributes = {"description": meaning} | ({"units": unit} if unit else {})
            variables[name] = (dimensions, getattr(recording, name), attributes)
    heard = np.stack([recording.neighbours(step) for step in range(recording.steps)])
    variables["heard"] = (("step", "node", "agent"), heard, {"description": "the agent heard the node"})
    actions = [recording.vocabulary.action_text(number) for number in range(len(recording.vocabulary.actions))]
    return xarray.Dataset(
        variables,
        coords={
            "node": [*(str(agent) for agent in range(recording.agents)), "source", "sink"],
            "channel": [recording.vocabulary.channels[channel] for channel in recording.channels],
        },
        attrs={
            "fitness": recording.fitness,
            "seed": recording.scenario.seed,
            "actions": actions,
            "fates": [fate.name.lower() for fate in Fate],
        },
    )
