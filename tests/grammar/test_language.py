"""What the rules of a batch can say, and the numbers of users' clauses, targets and actions."""

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.grammar import load_grammar, parse_grammar
from slcs2_jax.grammar.language import Language
from slcs2_jax.grammar.vocabulary import PAPER, Vocabulary
from slcs2_jax.policy.decision_list import parse_decision_list
from tests.builders import registered

PARTS = {
    "clause": {"in a crowd": "a clause", "at rest": "another"},
    "move target": {"middle": "a target"},
    "action": {"whisper to sink": "an action", "shout": "another"},
}
NEW_CLAUSES, NEW_ACTIONS = len(PAPER.clauses), len(PAPER.actions)


@pytest.fixture(scope="module")
def extended():
    """The vocabulary with parts of a user's own; they are forgotten again, so that others' is the paper's."""
    with registered(PARTS):
        return Vocabulary.current()


def test_users_parts_come_last_and_change_no_number(extended):
    assert extended.clauses[:NEW_CLAUSES] == PAPER.clauses
    assert extended.actions[:NEW_ACTIONS] == PAPER.actions
    assert [extended.clause_text(k) for k in range(NEW_CLAUSES, len(extended.clauses))] == ["in a crowd", "at rest"]
    own = ["move toward middle", "move away from middle", "orbit middle", "whisper to sink", "shout"]
    assert [extended.action_text(k) for k in range(NEW_ACTIONS, len(extended.actions))] == own
    for number, text in enumerate(own, start=NEW_ACTIONS):
        assert extended.parse_action(text) == number
    assert extended.first_own == NEW_ACTIONS
    assert extended.own_clauses == tuple(PARTS["clause"].items())


def test_once_forgotten_they_are_not_known(extended):
    assert Vocabulary.current() is PAPER
    with pytest.raises(InputError, match="clause: 'in a crowd' is not known"):
        PAPER.parse_clause("in a crowd")
    assert "in a crowd" in extended.clause_names
    assert "whisper to sink" in extended.action_names
    assert "middle" in extended.action_names


@pytest.mark.parametrize(
    ("kind", "name"),
    [("clause", "packet held"), ("clause", "d_si<net"), ("action", "send to si"), ("action", "orbit c")],
)
def test_words_that_mean_something_else_already_are_refused(kind, name):
    with registered({kind: {name: None}}), pytest.raises(InputError, match=f"^{kind} .* is there twice"):
        Vocabulary.current()


def test_there_are_only_so_many_actions():
    with (
        registered({"action": {f"dance {k}": None for k in range(199)}}),
        pytest.raises(InputError, match="256 in all"),
    ):
        Vocabulary.current()
    with registered({"action": {f"dance {k}": None for k in range(198)}}):
        assert len(Vocabulary.current().actions) == 255


def test_other_channels_have_clauses_and_actions_of_their_own():
    two = Vocabulary.current((3, 8))
    assert two.clause_text(two.noise_clause(1)) == "noise on 8 <= P_rs"
    assert len(two.clauses) == NEW_CLAUSES - 1
    assert two.action_text(two.send_action(1, 1)) == "send to si on 8"
    assert [two.actions[two.collect_action(channel)].channel for channel in range(2)] == [0, 1]
    with pytest.raises(InputError, match="clause: 'noise on 6"):
        two.parse_clause("noise on 6 <= P_rs")


@pytest.mark.parametrize(("name", "words"), [("main", 3), ("channel", 4), ("power", 3), ("both", 4)])
def test_the_papers_grammars_need_words_and_nothing_else(name, words):
    assert Language.of([load_grammar(name)]) == Language(PAPER, words)


def test_only_what_can_be_said_is_computed(extended):
    grammar = parse_grammar("<R> ::= in a crowd => shout | packet held => orbit middle", vocabulary=extended)
    language = Language.of([grammar])
    assert language.own_clauses == (NEW_CLAUSES,)
    assert language.own_actions == (NEW_ACTIONS + 2, NEW_ACTIONS + 4)
    assert (language.words, language.vocabulary) == (NEW_CLAUSES // 32 + 1, extended)
    first = parse_decision_list("packet held => move toward middle", vocabulary=extended)
    last_of_the_papers = parse_decision_list("packet held => send to sink on 11", vocabulary=extended)
    assert Language.of([first]).own_actions == (NEW_ACTIONS,)
    assert Language.of([last_of_the_papers]).own_actions == ()


def test_a_batch_says_what_any_of_it_says(extended):
    one = parse_decision_list("at rest => move toward so", vocabulary=extended)
    other = parse_decision_list("packet held => whisper to sink", vocabulary=extended)
    assert Language.of([other]).words == 1
    assert Language.of([one, other]) == Language(extended, 4, (NEW_CLAUSES + 1,), (NEW_ACTIONS + 3,))
    whole = Language.whole(extended)
    assert whole.own_clauses == (NEW_CLAUSES, NEW_CLAUSES + 1)
    assert whole.own_actions == tuple(range(NEW_ACTIONS, NEW_ACTIONS + 5))
    assert Language.whole(PAPER) == Language()


def test_vocabularies_are_not_mixed(extended):
    with pytest.raises(InputError, match="different vocabularies cannot share a batch"):
        Language.of([load_grammar("main"), load_grammar("main", vocabulary=extended)])


def test_a_language_is_part_of_compiled_programs(extended):
    assert hash(Language.whole(extended)) == hash(Language.whole(extended))
    assert Language.whole(extended) != Language.whole(PAPER)
