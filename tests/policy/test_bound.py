"""What is deployed: rule-sets, decision lists, a network written by hand, and policies chosen by name."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax import episode as episodes
from slcs2_jax.config import InputError, Settings, Swarm, World
from slcs2_jax.episode import Parameters
from slcs2_jax.grammar import RuleSets, load_grammar, random_rule_sets
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.ruleset import parse_rule_text
from slcs2_jax.grammar.vocabulary import PAPER, SOURCE, TOWARD
from slcs2_jax.policy.bound import bind, bind_list, bind_rules
from slcs2_jax.policy.classifier import Classifier
from slcs2_jax.policy.decision_list import load_decision_list, parse_decision_list
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.policy.policy import Policy
from slcs2_jax.swarm.observation import feature_list, features
from slcs2_jax.world.arena import stack
from slcs2_jax.world.scenario import make_scenario
from tests.builders import registered


def rules_of(*texts):
    return RuleSets.from_rules([[parse_rule_text(text) for text in texts]] * 3)


def test_rule_sets_alone_may_say_everything_and_use_the_channels_they_name():
    bound = bind_rules(rules_of("packet held => send to si on 11", "noise on 6 <= P_rs => collect from source"))
    assert bound.policy == Classifier()
    assert bound.language == Language.whole(PAPER)
    assert bound.channels == (0, 1, 2)
    assert bind_rules(rules_of("packet held => move toward si")).channels == (0,)


def test_rule_sets_of_a_grammar_have_its_language_and_channels_whatever_they_say():
    grammar, rules = load_grammar("both"), rules_of("packet held => move toward si")
    bound = bind_rules(rules, grammar)
    assert bound.language == Language.of([grammar])
    assert bound.channels == grammar.channels_used == (0, 1, 2)
    assert bound.given is rules
    main = bind_rules(rules, load_grammar("main"), FirstMatch())
    assert main.policy == FirstMatch()
    assert main.policy.arrays(main.given, main.language).mask.shape == (3, 1, 3)  # words, rules, agents


def test_a_decision_list_is_every_agents():
    decisions = load_decision_list("designed")
    bound = bind_list(decisions, 5)
    assert bound.policy == FirstMatch()
    assert bound.given.action.shape == (5, len(decisions.rules))
    assert (bound.language, bound.channels) == (Language.of([decisions]), decisions.channels_used)
    assert bind_list(parse_decision_list("packet held => send to si on 11"), 2).channels == (2,)


@dataclasses.dataclass(frozen=True)
class Line(Policy):
    """A network of one layer: the greatest of a weighted sum of the figures decides between two actions."""

    @property
    def channels(self):
        return (0, 2)

    def initial_memory(self, parameters, agents, learning):
        return None

    def decide(self, memory, parameters, seen, clock, learning):
        logits = jnp.tensordot(parameters["weight"], features(seen.view), axes=[[1], [0]]) + parameters["bias"][:, None]
        known = jnp.array([PAPER.move_action(TOWARD, SOURCE), PAPER.collect_action()], jnp.int32)
        return memory, known[jnp.argmax(logits, axis=0)]


def test_a_network_by_hand_does_as_its_figures_say():
    """It collects when the source is near, less than a fifth of net, and walks to it before."""
    names = [feature.name for feature in feature_list(1)]
    weight = np.zeros((2, len(names)), np.float32)
    weight[0, names.index("d_source")] = 1
    bound = bind(Line(), {"weight": jnp.asarray(weight), "bias": jnp.array([0, 0.2])})
    assert (bound.policy, bound.channels, bound.language) == (Line(), (0, 2), Language.whole(PAPER))
    assert all(isinstance(leaf, np.ndarray) for leaf in jax.tree.leaves(bound.given))
    settings = Settings(world=World(distance=300.0, time_limit=50), swarm=Swarm(agents=2, packets=1))
    scenario = make_scenario(settings, 0)
    scenario = dataclasses.replace(scenario, start=np.array([(20, 0), (100, 40)], np.float32))
    arena = jax.tree.map(lambda leaf: jnp.asarray(leaf[..., 0]), stack([scenario], [(0,)], capacity=(0, 0), width=1))
    parameters = Parameters.of(settings, bound.policy, bound.language)
    episode = episodes.begin(
        arena, bound.policy.arrays(bound.given, bound.language), jnp.zeros(2, jnp.uint32), parameters
    )
    episode, moment = jax.jit(episodes.step)(episode, parameters)
    assert moment.action.tolist() == [PAPER.collect_action(), PAPER.move_action(TOWARD, SOURCE)]
    assert np.hypot(episode.state.x[1], episode.state.y[1]) < np.hypot(100, 40) - 1.9
    assert episode.memory is None


def test_a_policy_may_be_named():
    with registered({"policy": {"line": Line}}):
        assert bind("line", {}).policy == Line()
    with pytest.raises(InputError, match=r"^policy=line: accepted is one of classifier, "):
        bind("line", {})
    with pytest.raises(InputError, match=r"^policy: ndarray; accepted is a Policy or the name of one$"):
        bind(np.zeros(3), {})


def test_rule_sets_under_a_policy_that_is_named_are_laid_out_as_rules():
    rules = random_rule_sets(load_grammar("main"), 3, 4, np.random.default_rng(0))
    bound = bind("classifier", rules)
    assert bound.policy.arrays(bound.given, bound.language).action.shape == (4, 3)
