"""Studies: nothing but the same instances after the same number of generations is compared, and what lacks is told."""

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.results.arm import Cell, cell_named
from slcs2_jax.study.collect import collect
from slcs2_jax.study.study import BEST, FRESH, SPENT, Contest, studies
from slcs2_jax.study.table import failures_table

EXPERIMENTS = {
    "contributions": ("Contributions", ("slcs2", "ailta", "no_exchange")),
    "grammars": ("Grammars", ("slcs2", "channel", "power")),
}
OPEN = cell_named("open_short")
SHORT = ("open_short", "jammed_short", "urban_short", "urban_jammed_short")


def study(make, **given):
    return studies(collect(make.root), EXPERIMENTS, **given)


def test_arms_are_compared_on_the_instances_that_all_have(make):
    for seed, best in enumerate([0.5, 0.6, 0.7]):
        make.evolved("slcs2", "open_short", seed, [best], fresh=best - 0.1)
    for seed in (0, 2, 9):
        make.evolved("ailta", "open_short", seed, [0.1 * seed], fresh=0.0)
    [one] = study(make)
    assert (one.name, one.arms, one.seeds(OPEN, BEST)) == ("contributions", ("slcs2", "ailta"), (0, 2))
    assert list(one.sample("slcs2", OPEN, BEST)) == [0.5, 0.7]
    assert list(one.sample("ailta", OPEN, BEST)) == [0.0, 0.2]
    assert one.descriptions(BEST)["slcs2", OPEN].mean == pytest.approx(0.6)
    assert one.comparisons(BEST)[Contest("ailta", OPEN)].difference == pytest.approx(0.5)
    assert one.comparisons(FRESH)[Contest("ailta", OPEN)].difference == pytest.approx(0.5)
    assert "SLCS2, short open: no run (seed 9)" in one.missing
    assert "no novelty (AILTA), short open: no run (seed 1)" in one.missing


def test_cells_whose_seeds_differ_count_alike_overall(make):
    counts = dict(zip(SHORT, (3, 2, 4, 2), strict=True))
    for place, (cell, count) in enumerate(counts.items()):
        for instance in range(count):
            make.evolved("slcs2", cell, 1000 * place + instance, [0.1 * place + 0.01 * instance])
            make.evolved("ailta", cell, 1000 * place + instance, [0.0])
    [one] = study(make)
    overall = one.sample("slcs2", cell_named("overall_short"), BEST)
    assert list(overall) == pytest.approx([0.0, 0.01, 0.1, 0.11, 0.2, 0.21, 0.3, 0.31])
    assert len(one.sample("slcs2", OPEN, BEST)) == 3
    assert not [line for line in one.missing if "no run (" in line]


def test_arms_are_compared_after_the_generations_that_all_have(make):
    make.evolved("slcs2", "open_short", 0, [0.1, 0.2, 0.9], fresh=0.8)
    make.evolved("ailta", "open_short", 0, [0.1, 0.15], planned=3)
    [one] = study(make)
    assert one.generations == 2
    assert list(one.sample("slcs2", OPEN, BEST)) == [0.2]  # not the 0.9 of generation 3
    assert not len(one.sample("slcs2", OPEN, FRESH))  # its winner is not that of generation 2
    assert "no novelty (AILTA), short open: 2 of 3 generations (all seeds)" in one.missing
    assert "SLCS2, short open: no fresh deployments after generation 2 (all seeds)" in one.missing
    [three] = study(make, generations=3)
    assert three.generations == 3
    assert not three.descriptions(BEST)
    with pytest.raises(InputError, match="generations=4: accepted is a whole number from 1 to 3"):
        study(make, generations=4)


def test_a_run_that_has_not_begun_holds_nothing_back(make):
    make.evolved("slcs2", "open_short", 0, [0.1, 0.2])
    make.evolved("slcs2", "open_short", 1, [], planned=2)
    make.evolved("ailta", "open_short", 0, [0.1, 0.2])
    [one] = study(make)
    assert (one.generations, one.seeds(OPEN, BEST)) == (2, (0,))
    assert "SLCS2, short open: not begun (seed 1)" in one.missing


def test_cells_that_an_arm_has_not_begun_hold_nothing_back(make):
    for arm in ("slcs2", "channel"):
        make.evolved(arm, "open_short", 0, [0.1, 0.2, 0.3])
    make.evolved("slcs2", "open_long", 0, [0.1], planned=3)
    [one] = study(make)
    assert (one.name, one.generations) == ("grammars", 3)


def test_overall_is_of_all_types_and_worlds_of_one_seed_count_once(make):
    level = dict(zip(SHORT, (0.1, 0.2, 0.3, -1.0), strict=True))
    for arm in ("slcs2", "ailta"):
        for cell, best in level.items():
            for seed in range(3 if cell == "open_short" else 2):
                make.evolved(arm, cell, seed, [best + (seed if best > -1 else 0)])
    overall = Cell("overall", "short")
    [one] = study(make)
    assert list(one.sample("slcs2", overall, BEST)) == pytest.approx([-0.1, 0.65])
    assert one.descriptions(BEST)["slcs2", overall].mean == pytest.approx(0.275)
    assert one.comparisons(BEST)[Contest("ailta", overall)].count == 2
    failed = {row[0]: row[2:4] for row in failures_table(one).rows if row[1] == "SLCS2"}
    assert failed["short overall"] == (8, 0.25)
    assert failed["short urban jammed"] == (2, 1.0)
    assert not len(one.sample("slcs2", Cell("overall", "long"), BEST))
    assert "no runs at all: long open, long jammed, long urban, long urban jammed" in one.missing


def test_overall_of_three_types_is_not_told(make):
    for arm in ("slcs2", "ailta"):
        for cell in SHORT[:3]:
            make.evolved(arm, cell, 0, [0.5])
    [one] = study(make)
    assert {place.name for _, place in one.descriptions(BEST)} == set(SHORT[:3])


def test_holms_family_is_all_cells_of_the_experiment_and_overall_is_another(make):
    for cell in SHORT:
        for seed in range(4):
            make.evolved("slcs2", cell, seed, [0.5 + seed / 100])
            for arm in ("ailta", "no_exchange"):
                make.evolved(arm, cell, seed, [0.1 + seed / 100])
    [one] = study(make)
    factors: dict = {}
    for contest, found in one.comparisons(BEST).items():
        factors.setdefault(contest.place.environment == "overall", []).append(found.p_holm / found.p_mann_whitney)
    assert factors[False] == pytest.approx([8.0] * 8)  # equal p: each times the size of the family
    assert factors[True] == pytest.approx([2.0] * 2)


def test_each_experiment_has_its_own_instances_and_generations(make):
    for seed in range(2):
        make.evolved("slcs2", "open_short", seed, [0.1, 0.5])
    make.evolved("ailta", "open_short", 0, [0.1])
    make.evolved("channel", "open_short", 1, [0.1, 0.2])
    first, second = study(make)
    assert (first.name, first.generations, first.seeds(OPEN, BEST)) == ("contributions", 1, (0,))
    assert (second.name, second.generations, second.seeds(OPEN, BEST)) == ("grammars", 2, (1,))


def test_arms_of_no_experiment(make):
    make.evolved("no_exchange", "open_short", 0, [0.1])
    [one] = study(make)
    assert (one.name, one.arms) == ("runs", ("no_exchange",))
    assert not one.comparisons(BEST)
    make.evolved("both", "open_short", 0, [0.2])
    [two] = study(make)
    assert two.arms == ("no_exchange", "both")
    assert list(two.comparisons(BEST)) == [Contest("both", OPEN)]


def test_curves(make):
    make.evolved("slcs2", "open_short", 0, [0.1, 0.2, 0.3])
    make.evolved("slcs2", "open_short", 1, [0.3, 0.4])
    make.designed("open_short", 0, [0.4, 0.6])
    make.designed("open_short", 1, [-1.0])
    [one] = studies(collect(make.root), {"designed": ("Designed", ("slcs2", "designed"))})
    assert one.generations == 2
    np.testing.assert_allclose(one.curves("slcs2", OPEN), [[0.1, 0.2], [0.3, 0.4]])
    np.testing.assert_allclose(one.curves("designed", OPEN), [[0.5, 0.5], [-1.0, -1.0]])
    assert one.comparisons(FRESH) == {}
    assert one.comparisons(BEST)[Contest("designed", OPEN)].difference == pytest.approx(0.3 - -0.25)


def test_curves_by_what_was_spent_begin_and_end_where_every_search_has_a_figure(make):
    make.evolved("slcs2", "open_short", 0, [0.1, 0.2, 0.3], deployments=[1, 3, 6])
    make.evolved("ailta", "open_short", 0, [0.0, 0.4, 0.5], deployments=[2, 1, 2])
    make.designed("open_short", 0, [0.6])
    arms = {"one": ("One", ("slcs2", "ailta", "designed"))}
    [one] = studies(collect(make.root), arms)
    for by, each in (("episodes", 1), ("env-steps", 50)):
        looks = one.looks(OPEN, by)
        assert (looks[0], looks[-1], np.diff(looks).min() > 0) == (2 * each, 5 * each, True)
        [own], [other], [designed] = (one.curves(arm, OPEN, by) for arm in arms["one"][1])
        assert own.tolist() == [0.1 if at < 4 * each else 0.2 for at in looks]
        assert other.tolist() == [0.0 if at < 3 * each else 0.4 if at < 5 * each else 0.5 for at in looks]
        assert set(designed) == {0.6}
    [early] = studies(collect(make.root), arms, generations=2)
    assert early.looks(OPEN, "episodes")[-1] == 3


def test_what_has_not_begun_in_a_world_has_no_curve_there(make):
    for speed, jammed in ((2.0, [0.1, 0.2]), (4.0, [])):
        other = type(make)(make.root / f"{speed}")
        for cell, best in (("open_short", [0.1, 0.3]), ("jammed_short", jammed)):
            other.evolved("slcs2", cell, 0, best, planned=2, swarm={"speed": speed})
    [one] = studies(collect(make.root), {})
    for by in SPENT:
        assert [len(one.curves(arm, cell_named("jammed_short"), by)) for arm in one.arms] == [1, 0]
        assert [len(one.curves(arm, OPEN, by)) for arm in one.arms] == [1, 1]


def test_searches_that_stop_by_their_episodes_are_looked_at_where_they_ended(make):
    budget = {"search": {"episodes": 150}}
    for seed, best in enumerate([[0.1, 0.2, 0.5], [0.3], [0.1, 0.4]]):
        make.evolved("slcs2", "open_short", seed, best, fresh=best[-1] - 0.1, planned=500, **budget)
        if seed < 2:
            make.evolved("ailta", "open_short", seed, [0.0, 0.05 * seed], fresh=-0.1, planned=500, **budget)
    make.evolved("ailta", "open_short", 2, [0.0, 0.3], planned=500, **budget)
    make.designed("open_short", 0, [0.2, 0.4])
    arms = {"budget": ("Budget", ("slcs2_150_episodes", "ailta_150_episodes"))}
    [one, _] = studies(collect(make.root), arms | EXPERIMENTS)
    assert (one.name, one.arms, one.to_end) == ("budget", arms["budget"][1], True)
    assert one.generations == 3
    assert list(one.sample("slcs2_150_episodes", OPEN, BEST)) == [0.5, 0.3]
    assert list(one.sample("slcs2_150_episodes", OPEN, FRESH)) == pytest.approx([0.4, 0.2])
    assert one.curves("slcs2_150_episodes", OPEN).tolist() == [[0.1, 0.2, 0.5], [0.3, 0.3, 0.3]]
    assert "no novelty (AILTA), 150 episodes, short open: not ended (seed 2)" in one.missing
    assert not any("generation" in line for line in one.missing)
    [early, _] = studies(collect(make.root), arms | EXPERIMENTS, generations=1)
    assert list(early.sample("slcs2_150_episodes", OPEN, BEST)) == [0.1, 0.3, 0.1]
