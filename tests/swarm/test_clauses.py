"""Clauses of a user's own: computed where a rule can state them, and refused in one line where they cannot be.

The paper's clauses are tested in test_observation.
"""

import jax.numpy as jnp
import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.grammar import parse_grammar
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.ruleset import parse_rule_text
from slcs2_jax.grammar.vocabulary import PAPER, Vocabulary
from slcs2_jax.swarm import observation
from slcs2_jax.swarm.clauses import truth
from tests.builders import registered

NUMBER = len(PAPER.clauses)
SAYS_IT = "<R> ::= far right & packet held => move toward so"
SAYS_NOTHING = "<R> ::= packet held => move toward so"


def view_of(make, **fields):
    arena = make.arena([(30, 0), (80, 0), (120, 0)])
    physics = make.physics()
    return make.look(make.state(arena, holding=[1], **fields), make.links(3), arena, physics)


def language(part, text=SAYS_IT):
    with registered({"clause": {"far right": part}}):
        return Language.of([parse_grammar(text, vocabulary=Vocabulary.current())])


def holds(found, number):
    return (np.asarray(found)[number // 32] >> np.uint32(number % 32) & 1).astype(bool).tolist()


def test_an_own_clause_is_true_where_it_says_so_and_leaves_the_others_alone(make):
    view = view_of(make)
    found = truth(view, language(lambda seen: seen.x > 50))
    assert holds(found, NUMBER) == [False, True, True]
    plain = truth(view, Language())
    assert holds(plain, NUMBER) == [False] * 3
    for number in range(NUMBER):
        assert holds(found, number) == holds(plain, number)


def test_one_truth_for_all_is_enough(make):
    assert holds(truth(view_of(make), language(lambda seen: jnp.array(True))), NUMBER) == [True] * 3


def test_it_is_computed_only_where_a_rule_can_state_it(make):
    asked = []

    def part(view):
        asked.append(view)
        return view.holding

    truth(view_of(make), language(part, SAYS_NOTHING))
    assert not asked
    truth(view_of(make), language(part))
    assert len(asked) == 1


def test_nothing_is_true_once_the_episode_is_over(make):
    said = language(lambda seen: seen.x > 50)
    seen = observation.observe(view_of(make), said)
    assert holds(seen.truth, NUMBER) == [False, True, True]
    over = observation.observe(view_of(make, t=1000), said)
    assert not np.asarray(over.truth).any()


def test_a_rule_with_it_is_said_read_and_masked():
    said = language(lambda seen: seen.x > 50)
    rule = parse_rule_text("far right & packet held => move toward so", said.vocabulary)
    assert rule.text() == "packet held & far right => move toward so"
    assert rule.clauses == (1, NUMBER)
    assert rule.mask()[NUMBER // 32] == 1 << NUMBER % 32


@pytest.mark.parametrize(
    ("part", "told"),
    [
        (lambda view: view.x, r"float32\[3\]"),
        (lambda view: view.heard, r"bool\[5, 3\]"),
        (lambda view: True, "bool"),
        (lambda view: None, "NoneType"),
    ],
)
def test_a_wrong_shape_or_type_is_named_in_one_line(make, part, told):
    with pytest.raises(InputError, match=rf"^clause 'far right': returned {told}; accepted is bool\[3\]$"):
        truth(view_of(make), language(part))
