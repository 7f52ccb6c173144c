"""Grammars: what the paper's four derive, and what is refused with which line."""

import os
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.config.errors import InputError
from slcs2_jax.grammar import GRAMMARS, decode_rule, decode_rules, load_grammar, parse_grammar
from slcs2_jax.grammar.vocabulary import FULL, PAPER

HEAD = "<Rule> ::= <C> => <A>\n"
SMALL = HEAD + "<C> ::= <C> & <C> | packet held | no packet held\n<A> ::= orbit so | collect from source\n"

MAIN_ACTIONS = [*range(21), PAPER.collect_action(), *(PAPER.send_action(target) for target in range(5))]


def without(channels, powers):
    """Action numbers of a grammar with these channel and power indices."""
    airs = [(channel, power) for channel in channels for power in powers]
    sends = [PAPER.send_action(target, *air) for target in range(5) for air in airs]
    return sorted([*range(21), *(PAPER.collect_action(*air) for air in airs), *sends])


@pytest.mark.parametrize(
    ("name", "clauses", "actions", "channels", "words"),
    [
        ("main", list(range(80)), MAIN_ACTIONS, (0,), 3),
        ("channel", list(range(97)), without((0, 1, 2), (FULL,)), (0, 1, 2), 4),
        ("power", list(range(95)), without((0,), (0, 1)), (0,), 3),
        ("both", list(range(len(PAPER.clauses))), list(range(len(PAPER.actions))), (0, 1, 2), 4),
    ],
)
def test_paper_grammars_derive_exactly_their_vocabulary(name, clauses, actions, channels, words):
    grammar = load_grammar(name)
    assert list(grammar.clauses) == clauses
    assert list(grammar.actions) == actions
    assert (grammar.channels_used, grammar.words) == (channels, words)


def options(grammar, name):
    return [
        " ".join(s if isinstance(s, str) else f"<{s.name}>" for s in o.body) for o in grammar.productions[name].options
    ]


def test_paper_option_order():
    """The tables of the paper, option by option."""
    main = load_grammar("main")
    assert options(main, "Condition") == [
        "<Condition> & <Condition>",
        "NI <= P_rs",
        "<Packet>",
        "<Neigh. Type>",
        "<Distance>",
    ]
    assert options(main, "Packet") == ["packet held", "no packet held"]
    assert options(main, "Neigh. Type") == ["node in reach", "no node in reach"]
    assert options(main, "Left") == ["d_so", "d_si", "d_c", "d_sink", "d_source"]
    assert options(main, "Operator") == ["<", ">", "="]
    assert options(main, "Right") == ["d_so", "d_si", "d_c", "d_th", "net"]
    assert options(main, "Action") == ["move <Direction> <Move target>", "<Networking>"]
    assert options(main, "Direction") == ["toward", "away from", "orbit"]
    assert options(main, "Move target") == ["so", "si", "c", "source", "sink", "jammer", "obstacle"]
    assert options(main, "Networking") == ["<Collect>", "<Send>"]
    assert options(main, "Send target") == ["so", "si", "c", "source", "sink"]
    both = load_grammar("both")
    assert options(both, "Right") == ["d_so", "d_si", "d_c", "d_th", "net", "xi"]
    assert options(both, "Channel") == ["1", "6", "11"]
    assert options(both, "Power") == ["half power", "full power"]
    for name in (
        "Packet",
        "Neigh. Type",
        "Left",
        "Operator",
        "Action",
        "Direction",
        "Move target",
        "Networking",
        "Send target",
    ):
        for special in ("channel", "power", "both"):
            assert options(load_grammar(special), name) == options(main, name)


def test_source_hash_tells_what_decodes_differently():
    hashes = {load_grammar(name).source_hash for name in GRAMMARS}
    hashes |= {
        load_grammar("main", max_clauses=4).source_hash,
        load_grammar("main", single_option_consumes=True).source_hash,
    }
    assert len(hashes) == 6
    assert load_grammar("main").source_hash in hashes


def test_notation():
    """Comments, continuation lines, quotes of both kinds, `->`, no spaces, options below the head, names with any
    spacing."""
    text = """\ufeff# a comment
    <Rule>::=<C>=><A>   # another
    <C> ::=
        | d_si<O>net    # not "quoted
        | < C > & <C>
    <O> -> "<" | '>'
       # a comment between
        |"="
    <A> ::= 'orbit so' | "collect from" source
    """
    grammar = parse_grammar(text.replace("\n", "\r\n"))
    assert [grammar.clauses, grammar.actions] == [(24, 29, 34), (14, 22)]
    assert options(grammar, "O") == ["<", ">", "="]
    assert decode_rule(grammar, [2, 2, 1]).text() == "d_si = net => collect from source"


def test_words_may_be_cut_anywhere_between_productions():
    text = """<S> ::= <Half> <Rest>
    <Half> ::= no | packet held & no
    <Rest> ::= packet held & d_so <Tail>
    <Tail> ::= < net => <A> | = xi => move <A>
    <A> ::= orbit so"""
    grammar = parse_grammar(text)
    assert decode_rule(grammar, [1, 0]).text() == "packet held & no packet held & d_so < net => orbit so"
    assert decode_rule(grammar, [0, 1]).text() == "no packet held & d_so = xi => orbit so"
    assert grammar.words == 3


def test_an_unused_production_is_no_fault():
    assert parse_grammar(SMALL + "<Spare> ::= whatever it says\n").clauses == (1, 2)


INVALID = {
    "empty": ("", "no production"),
    "only comments": ("# nothing\n\n", "no production"),
    "no arrow": ("<Rule> = a\n", r"line 1: expected '<Name> ::="),
    "stray continuation": ("| a\n", "line 1: expected"),
    "prose": (SMALL + "hello\n", "line 4: expected"),
    "unclosed quote": (HEAD + '<C> ::= "packet held\n<A> ::= orbit so\n', 'line 2: the quote " is not closed'),
    "empty option": (HEAD + "<C> ::= packet held |\n<A> ::= orbit so\n", "line 2: <C> has an empty option"),
    "empty option in the middle": (
        HEAD + "<C> ::= packet held\n | | node in reach\n",
        "line 3: <C> has an empty option",
    ),
    "empty quotes": (HEAD + '<C> ::= ""\n<A> ::= orbit so\n', "line 2: <C> has no option"),
    "no option at all": (HEAD + "<C> ::= \n<A> ::= orbit so\n", "line 2: <C> has no option"),
    "twice": (SMALL + "<C> ::= packet held\n", "line 4: <C> is already defined in line 2"),
    "no production": (
        HEAD + "<C> ::= <Pack>\n<A> ::= orbit so\n",
        "line 2: <Pack> has no production; productions are: <Rule>, <C>, <A>",
    ),
    "no production, unused": (SMALL + "<D> ::= <E>\n", "line 4: <E> has no production"),
    "endless": (HEAD + "<C> ::= <C> & <C>\n<A> ::= orbit so\n", "<C> cannot terminate"),
    "endless by two": (HEAD + "<C> ::= <D>\n<D> ::= <C> | <C> & <D>\n<A> ::= orbit so\n", "cannot terminate"),
    "endless start": ("<S> ::= <S>\n", "line 1: <S> cannot terminate"),
    "endless, unused": (SMALL + "<D> ::= a <D>\n", "line 4: <D> cannot terminate"),
    "unknown observation": (
        HEAD + "<C> ::= packet held | packet lost\n<A> ::= orbit so\n",
        "line 2: after 'packet' 'lost' is not known; .* held",
    ),
    "unknown first word": (
        HEAD + "<C> ::= battery low\n<A> ::= orbit so\n",
        "line 2: at the start .* 'battery' is not known; .*packet.*d_source",
    ),
    "unknown action": (
        HEAD + "<C> ::= packet held\n<A> ::= orbit <T>\n<T> ::= so | home\n",
        "line 4: after 'orbit' 'home' is not known; .*obstacle",
    ),
    "operands swapped": (HEAD + "<C> ::= net > d_si\n<A> ::= orbit so\n", "line 2: .*'net' is not known"),
    "unfinished clause": (
        HEAD + "<C> ::= d_si <\n<A> ::= orbit so\n",
        "line 1: after 'd_si <' '=>' is not known; .*net",
    ),
    "unfinished action": (
        HEAD + "<C> ::= packet held\n<A> ::= orbit\n",
        "line 1: .*after 'orbit' the rule ends; .*sink",
    ),
    "no action": ("<C> ::= packet held\n", "must derive 'condition => action'"),
    "two actions": (
        "<S> ::= packet held => orbit so orbit si\n",
        "line 1: after 'orbit so' 'orbit' is not known; .*end of the rule",
    ),
    "two arrows": ("<S> ::= packet held => orbit so => orbit so\n", "line 1: after 'orbit so' '=>' is not known"),
    "no condition": ("<S> ::= => orbit so\n", "line 1: at the start of a condition"),
    "joint at the end": ("<S> ::= packet held & => orbit so\n", "line 1: at the start of a condition"),
    "too many clauses": (
        "<S> ::= " + " & ".join(["packet held"] * 9) + " => orbit so\n",
        "line 1: no rule has max_clauses=8",
    ),
    "control characters": ("<S> ::= packet\x00held => orbit so\n", r"line 1: .*'packet\\x00held' is not known"),
}


@pytest.mark.parametrize("case", INVALID)
def test_invalid_grammar(case):
    text, message = INVALID[case]
    with pytest.raises(InputError, match=message) as caught:
        parse_grammar(text, name="mine.bnf")
    assert str(caught.value).startswith("grammar 'mine.bnf': ")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 700


def test_user_file(tmp_path):
    path = tmp_path / "mine.bnf"
    path.write_text(SMALL, encoding="utf-8")
    assert load_grammar(path).actions == load_grammar(str(path)).actions == (14, 22)


def test_files_that_are_none(tmp_path):
    (tmp_path / "latin").write_bytes(b"<C> ::= \xe9\n")
    (tmp_path / "large").write_bytes(b"#" * (64 * 1024 + 1))
    os.mkfifo(tmp_path / "pipe")
    cases = {
        tmp_path: "is a folder; accepted is a regular file",
        tmp_path / "pipe": "is a pipe; accepted is a regular file",
        tmp_path / "none.bnf": "no such grammar or file; accepted are main, channel, power, both",
        "mian": "no such grammar or file",
        "": "cannot be read|is a folder",
        "a\0b": "cannot be read|no such",
        "x" * 5000: "cannot be read|no such",
        tmp_path / "latin": "not UTF-8 text",
        tmp_path / "large": "65,537 bytes; accepted are at most 65,536",
        7: "is no name",
        None: "is no name",
        b"main": "is no name",
    }
    for path, message in cases.items():
        with pytest.raises(InputError, match=message) as caught:
            load_grammar(path)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize("value", [0, -1, 65, 2.0, True, "8", None])
def test_max_clauses_refused(value):
    with pytest.raises(InputError, match="max_clauses"):
        load_grammar("main", max_clauses=value)


def test_other_arguments_refused():
    with pytest.raises(InputError, match="single_option_consumes"):
        load_grammar("main", single_option_consumes=1)
    with pytest.raises(InputError, match="expected text"):
        parse_grammar(b"<A> ::= b")
    with pytest.raises(InputError, match="characters are too many"):
        parse_grammar("#" * 70_000)


def attempt(load, *arguments, **named):
    """The grammar, or None where it is refused; a refusal must be one printable line."""
    try:
        return load(*arguments, **named)
    except InputError as error:
        reason = str(error)
    assert reason.isprintable()
    return None


def chain(length, body):
    """<N0> ::= body of <N1>, <N1> ::= body of <N2>, ..."""
    return "\n".join(f"<N{k}> ::= {body.format(next=f'<N{k + 1}>')}" for k in range(length))


HUGE = {
    "doubling": HEAD.replace("<C>", "<N0>")
    + chain(1000, "{next} & {next}")
    + "\n<N1000> ::= packet held\n<A> ::= orbit so",
    "long chain": HEAD.replace("<C>", "<N0>") + chain(3000, "{next}") + "\n<N3000> ::= packet held\n<A> ::= orbit so",
    "long chain with choices": HEAD.replace("<C>", "<N0>")
    + chain(1500, "{next} | {next} & <N0>")
    + "\n<N1500> ::= node in reach\n<A> ::= orbit so",
    "many options": HEAD + "<C> ::= <C> & <C> " + "| packet held " * 4000 + "\n<A> ::= orbit so",
    "many joints": "<R> ::= <C> => <A>\n<C> ::= <C> & <C>"
    + "".join(f" | packet held{' & <C>' * k}" for k in range(100))
    + "\n<A> ::= orbit so",
    "everything after everything": "<R> ::= <C> => <A>\n<A> ::= orbit so\n<C> ::= "
    + " | ".join(["packet held"] + [f"<P{k}>" for k in range(500)])
    + "\n"
    + "\n".join(
        f"<P{k}> ::= <C> & <P{(k * 7 + 1) % 500}> | no <P{(k * 3 + 2) % 500}> | packet held" for k in range(500)
    ),
    "brackets": "<" * 60_000,
    "open names": "<a " * 20_000,
    "one name": "<" + "a" * 60_000 + "> ::= b",
    "quotes": "<a> ::= " + "'" * 60_000,
    "bars": "<a> ::= " + "|" * 60_000,
}


@pytest.mark.parametrize("case", HUGE)
def test_large_and_hostile_grammars_answer_quickly(case):
    text = HUGE[case]
    assert len(text) <= 64 * 1024
    began = time.perf_counter()
    grammar = attempt(parse_grammar, text)
    if grammar is not None:
        codons = np.random.default_rng(1).integers(0, 256, (20, 40))
        mask, action = decode_rules(grammar, codons)
        rule = decode_rule(grammar, codons[3])
        assert (rule.mask() == mask[3]).all()
        assert rule.action == action[3]
    assert time.perf_counter() - began < 10


PIECES = [
    *(
        "<A>",
        "<B>",
        "<Rule>",
        "::=",
        "|",
        "&",
        "=>",
        "\n",
        "\n<A> ::=",
        "\n<B> ::=",
        '"',
        "'",
        "#",
        "<",
        "<=",
        " ",
        "\t",
    ),
    *("\r", "packet held", "no", "d_si", "net", "orbit so", "send to", "so", "\u2028", "\x00", "\ufeff"),
]


@settings(max_examples=300, deadline=2000)
@given(st.one_of(st.text(max_size=300), st.lists(st.sampled_from(PIECES), max_size=60).map("".join)))
def test_random_text_never_raises_anything_else(text):
    for candidate in (text, HEAD + text, SMALL + text):
        grammar = attempt(parse_grammar, candidate, name=text)
        if grammar is not None:
            decode_rules(grammar, np.zeros((2, 3), np.uint8))


@settings(max_examples=150, deadline=2000)
@given(st.binary(max_size=200))
def test_random_files_never_raise_anything_else(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "fuzz.bnf"
    path.write_bytes(data)
    attempt(load_grammar, path)


@settings(max_examples=150, deadline=2000)
@given(st.data())
def test_a_damaged_main_grammar_loads_or_says_why(data):
    text = load_grammar("main").text
    begin = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(begin, min(len(text), begin + 40)))
    damaged = text[:begin] + data.draw(st.sampled_from(["", *PIECES])) + text[end:]
    attempt(parse_grammar, damaged)
