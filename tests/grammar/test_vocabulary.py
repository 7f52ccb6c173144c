"""The vocabulary: numbering as documented, and words that lead back to their number."""

import pytest

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar import vocabulary as v
from slcs2_jax.grammar.vocabulary import PAPER

NUMBERS = [
    (0, "NI <= P_rs"),
    (1, "packet held"),
    (2, "no packet held"),
    (3, "node in reach"),
    (4, "no node in reach"),
    (5, "d_so < d_so"),
    (24, "d_si < net"),  # 5 + (1 * 3 + 0) * 5 + 4
    (79, "d_source = net"),
    (80, "d_so < xi"),
    (94, "d_source = xi"),
    (95, "noise on 6 <= P_rs"),
    (96, "noise on 11 <= P_rs"),
]
ACTION_NUMBERS = [
    (0, "move toward so"),
    (6, "move toward obstacle"),
    (13, "move away from obstacle"),
    (18, "orbit sink"),
    (20, "orbit obstacle"),
    (21, "collect from source at half power"),
    (22, "collect from source"),
    (23, "collect from source on 6 at half power"),
    (26, "collect from source on 11"),
    (28, "send to so"),
    (34, "send to si"),
    (38, "send to si on 11"),
    (56, "send to sink on 11"),
]


@pytest.mark.parametrize(("number", "text"), NUMBERS)
def test_clause_numbers(number, text):
    assert PAPER.clause_text(number) == text
    assert PAPER.parse_clause(text) == number


@pytest.mark.parametrize(("number", "text"), ACTION_NUMBERS)
def test_action_numbers(number, text):
    assert PAPER.action_text(number) == text
    assert PAPER.parse_action(text) == number


def test_every_number_round_trips_and_no_two_share_words():
    clauses = [PAPER.clause_text(k) for k in range(len(PAPER.clauses))]
    actions = [PAPER.action_text(k) for k in range(len(PAPER.actions))]
    assert [PAPER.parse_clause(text) for text in clauses] == list(range(97))
    assert [PAPER.parse_action(text) for text in actions] == list(range(57))
    said = [phrase for phrases in PAPER.clause_phrases + PAPER.action_phrases for phrase in phrases]
    assert len(set(said)) == len(said)


def test_the_data_say_what_the_words_say():
    for number, clause in enumerate(PAPER.clauses):
        if clause.kind == "distance":
            words = f"{v.LEFT[clause.left]} {v.OPERATORS[clause.operator]} {v.RIGHT[clause.right]}"
            assert PAPER.clause_text(number) == words
            assert number == PAPER.distance_clause(clause.left, clause.operator, clause.right)
        elif clause.kind == "noise":
            assert PAPER.parse_clause(f"noise on {v.CHANNELS[clause.channel]} <= P_rs") == number
    for number, action in enumerate(PAPER.actions):
        text = PAPER.action_text(number)
        assert text.startswith({"move": ("move", "orbit"), "collect": "collect", "send": "send to"}[action.kind])
        if action.kind == "move":
            assert text.endswith(" " + v.MOVE_TARGETS[action.target])
            assert v.DIRECTIONS[action.direction] in text
        else:
            assert ("half" in text) == (v.POWERS[action.power] == "half")
            assert ("on " in text) == (action.channel > 0)
            full = text.replace(" at half power", "")
            channel = v.CHANNELS[action.channel]
            said = full if action.channel else f"{full} on {channel}"
            assert PAPER.parse_action(f"{said} at {v.POWERS[action.power]} power") == number


@pytest.mark.parametrize(
    ("text", "number"), [("d_si<net", 24), ("  NI<=P_rs ", 0), ("noise on 1 <= P_rs", 0), ("d_sink =  xi", 91)]
)
def test_spacing_and_said_defaults_do_not_matter(text, number):
    assert PAPER.parse_clause(text) == number


@pytest.mark.parametrize(
    ("text", "number"), [("move away so", 7), ("move orbit c", 16), ("send to c on 1 at full power", 40)]
)
def test_other_words_for_actions(text, number):
    assert PAPER.parse_action(text) == number


@pytest.mark.parametrize(
    "text", ["", "d_si <", "d_si < d_sink", "packet", "NI <= net", "held\npacket", "=> &", "d_th < net"]
)
def test_unknown_clause(text):
    with pytest.raises(InputError, match="clauses are: packet held") as caught:
        PAPER.parse_clause(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "move", "move toward net", "send to obstacle", "collect from sink", "send to si on 7"]
)
def test_unknown_action(text):
    with pytest.raises(InputError, match="actions are: move toward"):
        PAPER.parse_action(text)


@pytest.mark.parametrize("number", [-1, 97, 1000])
def test_unknown_clause_number(number):
    with pytest.raises(InputError, match=r"0\.\.96"):
        PAPER.clause_text(number)


@pytest.mark.parametrize("number", [-1, 57, v.NO_ACTION])
def test_unknown_action_number(number):
    with pytest.raises(InputError, match=r"0\.\.56"):
        PAPER.action_text(number)
