"""A network that is saved by its name, and comes back from its file as the same policy."""

import numpy as np
import pytest

from slcs2_jax.config import InputError, Settings
from slcs2_jax.grammar import load_grammar
from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.policy.bound import bind
from slcs2_jax.policy.trained_network import initial_parameters
from slcs2_jax.results.policy_file import load_policy, save_policy


def parameters(grammar="main", **changes):
    return initial_parameters(load_grammar(grammar), np.random.default_rng(0), hidden=(4,), **changes)


@pytest.mark.parametrize("changes", [{}, {"recurrent": 3}, {"sampled": False}, {"grammar": "both"}])
def test_the_same_policy_comes_back_from_its_file(tmp_path, changes):
    bound = bind("network", parameters(**changes))
    save_policy(tmp_path / "policy.npz", "network", bound.given)
    saved = load_policy(tmp_path / "policy.npz")
    again = bind(saved.name, saved.given)
    assert again.policy == bound.policy
    assert hash(again.policy) == hash(bound.policy)
    assert (again.language, again.channels) == (bound.language, bound.channels)
    layers = again.policy.arrays(again.given, again.language)
    np.testing.assert_array_equal(layers["out"]["w"], bound.given["network"]["out"]["w"])


def test_it_says_all_that_the_policy_is():
    policy = bind("network", parameters("both", recurrent=3)).policy
    grammar = load_grammar("both")
    assert policy.actions == grammar.actions
    assert policy.channels == grammar.channels_used == (0, 1, 2)
    assert (policy.carry, policy.sample) == (3, True)
    assert policy.language.vocabulary == PAPER
    assert bind("network", parameters()).channels == (0,)


def edited(**changes):
    return parameters() | changes


def with_layer(name, value):
    given = parameters()
    given["network"][name] = value
    return given


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "has other parts; accepted are actions, channels, network, sampled"),
        (edited(actions=np.frombuffer(b"fly", np.uint8)), "action: 'fly' is not known"),
        (edited(actions=np.frombuffer(b"\xff", np.uint8)), "its actions are no text"),
        (edited(actions=np.frombuffer(b"send to si\nsend to si", np.uint8)), "an action is there twice"),
        (edited(channels=np.array([1.5])), "its channels are no list of whole numbers"),
        (edited(channels=np.array([1, 1])), "a channel is there twice"),
        (edited(sampled=np.array(1)), "sampled is neither true nor false"),
        (with_layer("dense", []), "its network has no list of 1 to 8 dense layers"),
        (with_layer("gru", {}), "its gru has other parts"),
        (with_layer("other", {}), "its network has other parts"),
        (with_layer("out", {"w": np.zeros((4, 3), np.float32), "b": np.zeros(3, np.float32)}), "has no 28 outputs"),
        (with_layer("out", {"w": np.zeros((4, 28)), "b": np.zeros(28, np.float32)}), "w is float64"),
        (with_layer("out", {"w": np.full((4, 28), np.nan, np.float32), "b": np.zeros(28, np.float32)}), "all finite"),
    ],
)
def test_what_is_none_is_refused_by_name(given, message):
    with pytest.raises(InputError, match=r"^policy=network: ") as caught:
        bind("network", given)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_actions_of_another_radio_are_those_of_its_words():
    """Numbers depend on how many channels there are; files hold words."""
    grammar = load_grammar("main", vocabulary=type(PAPER).current((1,)))
    given = initial_parameters(grammar, np.random.default_rng(0), hidden=(4,))
    policy = bind("network", given).policy
    words = [policy.language.vocabulary.action_text(k) for k in policy.actions]
    assert words == [grammar.vocabulary.action_text(k) for k in grammar.actions]
    assert Settings().radio.channels != (1,)
