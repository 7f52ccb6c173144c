"""The designer's rules in the first places of every rule-set."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config import InputError, Rules, Settings
from slcs2_jax.config.knowledge import Knowledge as KnowledgeSettings
from slcs2_jax.grammar import Grammar
from slcs2_jax.search import Knowledge


def knowledge(places: int = 20, **values) -> Knowledge | None:
    settings = Settings(knowledge=KnowledgeSettings(**values), rules=Rules(rules=places))
    return Knowledge.of(settings, Grammar.of(settings))


def problem(make, rules: int = 20, *, agents: int = 3, search: dict | None = None, **values):
    made = make.problem(agents=agents, rules=rules, **(search or {}))
    return dataclasses.replace(made, knowledge=knowledge(rules, **values))


def test_there_is_none_by_default():
    assert knowledge() is None


@pytest.mark.parametrize("homogeneous", [False, True])
def test_the_rules_stand_first_and_the_rest_is_as_without_them(make, homogeneous):
    search = {"homogeneous": homogeneous}
    without = make.problem(agents=3, rules=20, **search)
    known = problem(make, mode="suggested", search=search)
    plain, solution = (one.random_solution(one.supply(), 0) for one in (without, known))
    places = known.knowledge.count
    assert places == 10
    for agent in range(3):
        assert [solution.rules.text(agent, place) for place in range(places)] == [
            known.knowledge.rules.text(0, place) for place in range(places)
        ]
    np.testing.assert_array_equal(solution.ids[:, places:], plain.ids[:, places:])
    assert solution.rules.reflex is None
    known.check(solution, 0)


@pytest.mark.parametrize(("start", "reflexes"), [("packets", [2, 2, 2]), ("all", [10, 10, 10]), ("both", [2, 10, 2])])
def test_reflexes_at_first_are_those_about_packets_or_all(make, start, reflexes):
    known = problem(make, mode="reflex", start=start)
    for generation, count in enumerate(reflexes):
        flags = known.random_solution(known.supply(), generation).rules.reflex
        assert (flags.sum(axis=1) == count).all()
        assert flags[:, :2].all()  # the designed list begins with its packet rules


def test_a_solution_without_the_rules_is_refused(make):
    known = problem(make, mode="reflex")
    good = known.random_solution(known.supply(), 0)
    known.check(good, 0)
    with pytest.raises(InputError, match=r"lacks rules of knowledge\.rules"):
        known.check(make.solution(agents=3, rules=20), 0)
    flags = good.rules.reflex.copy()
    flags[1, 15] = True
    other = type(good).of(good.values() | {"reflex": flags})
    with pytest.raises(InputError, match="no other reflexes"):
        known.check(other, 0)


def test_lists_that_cannot_be_used_are_refused_in_one_line(tmp_path):
    with pytest.raises(InputError, match=r"knowledge.rules=designed: accepted is a list of at most rules.rules=9"):
        knowledge(9, mode="reflex")
    wrong = tmp_path / "list.txt"
    wrong.write_text("packet held => fly\n")
    with pytest.raises(InputError, match=r"list\.txt': line 1: action: 'fly' is not known"):
        knowledge(mode="suggested", rules=str(wrong))
    with pytest.raises(InputError, match=r"missing\.txt"):
        knowledge(mode="suggested", rules=str(tmp_path / "missing.txt"))


def test_a_list_that_the_grammar_cannot_say_is_refused(tmp_path):
    from slcs2_jax.grammar.vocabulary import PAPER

    settings = Settings(rules=Rules(rules=20))
    grammar = Grammar.of(settings)
    action = next(k for k in range(len(PAPER.actions)) if k not in grammar.actions)
    foreign = tmp_path / "list.txt"
    foreign.write_text(f"packet held => {PAPER.action_text(action)}\n")
    with pytest.raises(InputError, match=r"knowledge.rules=.*list.txt: accepted is rules that grammar=main can say"):
        knowledge(mode="suggested", rules=str(foreign))
