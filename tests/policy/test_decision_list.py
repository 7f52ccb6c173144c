"""Decision lists as text: what they say, and one line that names the place of any mistake."""

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slcs2_jax.config import InputError
from slcs2_jax.grammar import load_grammar, make_rule
from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.policy.decision_list import DECISION_LISTS, load_decision_list, parse_decision_list

rules = st.builds(
    make_rule,
    st.lists(st.integers(0, len(PAPER.clauses) - 1), min_size=1, max_size=6),
    st.integers(0, len(PAPER.actions) - 1),
)


@given(st.lists(rules, min_size=1, max_size=8), st.sampled_from(["\n", "\n\n", "   # a remark => really\n", "\r\n"]))
def test_every_list_of_rules_round_trips(written, end):
    text = "# first remark\n" + "".join(rule.text() + end for rule in written)
    decisions = parse_decision_list(text)
    assert decisions.rules == tuple(written)
    assert decisions.text == text
    sets = decisions.rule_sets(3)
    assert sets.action.shape == (3, len(written))
    assert [sets.rule(2, place) for place in range(len(written))] == written


@pytest.mark.parametrize(
    ("text", "channels", "words"),
    [
        ("packet held => send to si", (0,), 1),
        ("d_si < xi => move away from jammer", (0,), 3),
        ("packet held => send to si on 11", (2,), 1),
        ("noise on 6 <= P_rs => collect from source", (0, 1), 3),
        ("noise on 11 <= P_rs => move toward si", (2,), 4),
    ],
)
def test_channels_and_words_are_those_of_its_rules(text, channels, words):
    decisions = parse_decision_list(text)
    assert decisions.channels_used == channels
    assert decisions.words == words


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 rules; accepted are 1 to 1000, one a line"),
        ("# nothing", "0 rules; accepted are 1 to 1000, one a line"),
        ("packet held => send to si\n\npacket lost => send to si", "line 3: clause: 'packet lost' is not known"),
        ("packet held => fly", "line 1: action: 'fly' is not known; actions are: move toward"),
        ("packet held", "line 1: rule: 'packet held' is not of the form 'clause & clause => action'"),
        ("packet held => send to si\n" * 1001, "1001 rules; accepted are 1 to 1000"),
    ],
)
def test_mistakes_are_named(text, message):
    with pytest.raises(InputError) as found:
        parse_decision_list(text, name="mine.txt")
    assert str(found.value).startswith("policy 'mine.txt': ")
    assert message in str(found.value)
    assert "\n" not in str(found.value)


def test_a_users_own_is_read_from_its_file(tmp_path):
    path = tmp_path / "mine.txt"
    path.write_text("no packet held => collect from source\n")
    assert load_decision_list(path).rules == load_decision_list(str(path)).rules == (make_rule([2], 22),)
    assert load_decision_list(path).name == str(path)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda path: None, "there is no such policy or file; accepted are designed or the path of a text file"),
        (lambda path: path.mkdir(), "is a folder; accepted is a regular file"),
        (lambda path: path.write_bytes(b"\xff"), "not UTF-8 text"),
        (lambda path: path.write_bytes(b" " * (2**16 + 1)), "65,537 bytes; accepted are at most 65,536"),
    ],
)
def test_what_is_no_list_is_refused(tmp_path, make, message):
    path = tmp_path / "mine"
    make(path)
    with pytest.raises(InputError, match=message):
        load_decision_list(path)


@pytest.mark.parametrize("name", DECISION_LISTS)
def test_bundled_lists_can_be_said_in_the_main_grammar(name):
    """So a designed swarm sees and does what an evolved one can."""
    decisions, main = load_decision_list(name), load_grammar("main")
    for rule in decisions.rules:
        assert set(rule.clauses) <= set(main.clauses)
        assert rule.action in main.actions
    assert len(set(decisions.rules)) == len(decisions.rules)


def test_reading_a_list_does_not_start_jax():
    code = "import sys; from slcs2_jax.policy.decision_list import load_decision_list; load_decision_list('designed')"
    code += "; assert 'jax' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
