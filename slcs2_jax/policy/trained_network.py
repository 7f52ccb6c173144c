"""A network that was trained here, as a policy that is saved by its name `network` and comes back from its file."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar.grammar import Grammar
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.policy import layers
from slcs2_jax.policy.network import Network
from slcs2_jax.swarm.observation import feature_list

NAME = "network"  # that it is registered under
_PARTS = {"actions", "channels", "network", "sampled"}
_MOST_LAYERS, _MOST_LETTERS = 8, 2**16


@dataclasses.dataclass(frozen=True)
class TrainedNetwork(Network):
    """A network of `policy.layers` that all agents share, trained by `slcs2_jax.learning`.

    Its parameters say everything: `{"actions", "channels", "network", "sampled"}`, the words of the actions (UTF-8, one
    a line, uint8), the radio's channels (int), the layers, and whether actions are drawn by the logits (bool).
    """

    @classmethod
    def of(cls, given: Any) -> TrainedNetwork:
        """The policy of these parameters. Raises InputError, of one line, if they are none."""
        try:
            if not isinstance(given, dict) or set(given) != _PARTS:
                raise InputError(f"has other parts; accepted are {', '.join(sorted(_PARTS))}")
            vocabulary = Vocabulary.current(_channels(given["channels"]))
            actions = tuple(vocabulary.parse_action(words) for words in _words(given["actions"]))
            used = sorted({vocabulary.actions[k].channel for k in actions} - {-1}) or [0]
            _check(given["network"], len(feature_list(1 + used[-1])), len(actions) + 1)
            sampled = np.asarray(given["sampled"])
            if sampled.dtype != bool or sampled.shape != ():
                raise InputError("sampled is neither true nor false")
        except InputError as error:
            raise InputError(f"policy={NAME}: {error}") from None
        own = tuple(sorted({k for k in actions if k >= vocabulary.first_own}))
        language = Language(vocabulary, 1, (), own)
        return cls(layers.apply, actions, language, layers.memory(given["network"]), bool(sampled), tuple(used))

    def arrays(self, given: Any, language: Language) -> Any:
        """The layers alone: the rest is code."""
        return given["network"]


def initial_parameters(
    grammar: Grammar, rng: np.random.Generator, *, hidden: tuple[int, ...], recurrent: int = 0, sampled: bool = True
) -> dict[str, Any]:
    """Parameters of a network drawn at random, for `bind("network", ...)`; it takes the actions of a grammar."""
    vocabulary = grammar.vocabulary
    words = [vocabulary.action_text(k) for k in grammar.actions]
    used = {vocabulary.actions[k].channel for k in grammar.actions} | {0}
    figures = len(feature_list(1 + max(used)))
    return {
        "actions": np.frombuffer("\n".join(words).encode(), np.uint8),
        "channels": np.array(vocabulary.channels, np.int32),
        "network": layers.initial(rng, figures, len(words) + 1, hidden=hidden, recurrent=recurrent),
        "sampled": np.array(sampled),
    }


def _channels(given: Any) -> tuple[int, ...]:
    channels = np.asarray(given)
    if channels.dtype.kind not in "iu" or channels.ndim != 1 or not 1 <= channels.size <= 64 or (channels < 0).any():
        raise InputError("its channels are no list of whole numbers")
    if len(set(channels.tolist())) < channels.size:
        raise InputError("a channel is there twice")
    return tuple(channels.tolist())


def _words(given: Any) -> list[str]:
    letters = np.asarray(given)
    if letters.dtype != np.uint8 or letters.ndim != 1 or not 1 <= letters.size <= _MOST_LETTERS:
        raise InputError("its actions are no text")
    try:
        words = letters.tobytes().decode().split("\n")
    except UnicodeDecodeError:
        raise InputError("its actions are no text") from None
    if len(set(words)) < len(words):
        raise InputError("an action is there twice")
    return words


def _check(network: Any, figures: int, actions: int) -> None:
    """Raise InputError unless this is a network of `policy.layers` from so many figures to so many logits."""
    if not isinstance(network, dict) or set(network) - {"gru"} != {"dense", "out"}:
        raise InputError("its network has other parts; accepted are dense, out and gru")
    dense = network["dense"]
    if not isinstance(dense, list) or not 1 <= len(dense) <= _MOST_LAYERS:
        raise InputError(f"its network has no list of 1 to {_MOST_LAYERS} dense layers")
    before = figures
    for one in dense:
        before = _width(one, before)
    if "gru" in network:
        gru = network["gru"]
        if not isinstance(gru, dict) or set(gru) != {"input", "carry", "bias"}:
            raise InputError("its gru has other parts; accepted are input, carry and bias")
        units = np.shape(gru["carry"])[0] if np.ndim(gru["carry"]) == 2 else 0
        _shaped("gru.input", gru["input"], (before, 3 * units))
        _shaped("gru.carry", gru["carry"], (units, 3 * units))
        _shaped("gru.bias", gru["bias"], (3 * units,))
        before = units
    if _width(network["out"], before) != actions:
        raise InputError(f"its last layer has no {actions} outputs: its actions, and to do nothing")


def _width(layer: Any, inputs: int) -> int:
    """Outputs of a layer that has so many inputs."""
    if not isinstance(layer, dict) or set(layer) != {"w", "b"}:
        raise InputError("a layer has other parts; accepted are w and b")
    outputs = np.size(layer["b"])
    _shaped("b", layer["b"], (outputs,))
    _shaped("w", layer["w"], (inputs, outputs))
    return outputs


def _shaped(name: str, given: Any, shape: tuple[int, ...]) -> None:
    found = np.asarray(given)
    if found.dtype != np.float32 or found.shape != shape or 0 in shape or not np.isfinite(found).all():
        raise InputError(f"{name} is {found.dtype}{list(found.shape)}; accepted is float32{list(shape)}, all finite")
