"""The truth of every clause against plain Python."""

from __future__ import annotations

import numpy as np
import pytest

from slcs2_jax.grammar import vocabulary
from slcs2_jax.grammar.vocabulary import PAPER
from slcs2_jax.swarm.observation import feature_list, features

MARGIN = 2e-3  # m; nearer to a decision than a millimetre, rounding must not matter, and single precision may differ
P_RS = 10**-8.2


def truth_table(seen):
    """Bits as numbers: bool [clauses, agents]."""
    words = np.asarray(seen.truth)
    number = np.arange(32 * len(words))
    return (words[number // 32] >> (number % 32)[:, None].astype(np.uint32) & 1).astype(bool)


def operand(name, view, state, physics):
    if name == "d_th":
        return float(physics.swarm.distance_threshold)
    if name == "net":
        return float(physics.radio.network_range)
    if name == "xi":
        xi = float(state.jammer_range[view.me])
        return xi if xi > 0 else None
    return view.distance(name.removeprefix("d_"))


def plain_truth(number, view, state, physics):
    """Whether the clause holds, by its words; None where single precision may differ."""
    words = PAPER.clause_text(number)
    if words in ("packet held", "no packet held"):
        return bool(state.holding[view.me]) == (words == "packet held")
    if words in ("node in reach", "no node in reach"):
        return any(node in view.heard for node in (view.n, view.n + 1)) == (words == "node in reach")
    if words.endswith("<= P_rs"):
        channel = {"NI": 1, "6": 6, "11": 11}[words.removesuffix(" <= P_rs").split()[-1]]
        return bool(state.interference[(1, 6, 11).index(channel), view.me] <= P_RS)
    left, operator, right = words.split()
    a, b = operand(left, view, state, physics), operand(right, view, state, physics)
    if a is None or b is None:
        return False
    tolerance = max(float(physics.swarm.speed), float(physics.swarm.tolerance) * b)
    if 0 < abs(a - b) < MARGIN or abs(abs(a - b) - tolerance) < MARGIN:
        return None
    return {"<": a < b, ">": a > b, "=": abs(a - b) <= tolerance}[operator]


@pytest.mark.parametrize(
    "swarm", [{}, {"speed": 0.5, "tolerance": 0.2}, {"distance_threshold": 120.0, "tolerance": 0.0, "speed": 8.0}]
)
def test_every_clause_on_random_worlds(make, swarm):
    rng = np.random.default_rng(5)
    physics = make.physics(**swarm)
    outcomes = np.zeros((len(PAPER.clauses), 2), int)
    for trial in range(60):
        # distances of the size of the range, or of the tolerance, so that every outcome occurs
        size = (400.0, 150.0, 12.0)[trial % 3]
        state, links, arena = make.view(rng, size=size)
        truth = truth_table(make.see(state, links, arena, physics))
        assert not truth[len(PAPER.clauses) :].any()
        for i in range(5):
            view = make.plain(state, arena, links.heard, i)
            for number in range(len(PAPER.clauses)):
                expected = plain_truth(number, view, state, physics)
                if expected is not None:
                    assert truth[number, i] == expected, (PAPER.clause_text(number), trial, i)
                    outcomes[number, int(expected)] += 1
    # A distance is never less or greater than itself, always equal to itself where defined, and the closest
    # is never farther than another role: those clauses have one outcome, or few of the other.
    rare = {PAPER.parse_clause(f"d_{a} {o} d_{b}") for a, b in (("so", "so"), ("si", "si"), ("c", "c")) for o in "<>="}
    rare |= {PAPER.parse_clause(f"d_{a} < d_c") for a in ("so", "si", "sink", "source")}
    rare |= {PAPER.parse_clause(f"d_c > d_{a}") for a in ("so", "si")}
    rare |= {PAPER.parse_clause("d_sink < d_si"), PAPER.parse_clause("d_source < d_so")}
    often = np.array([k not in rare for k in range(len(PAPER.clauses))])
    assert (outcomes[often] > 0).all(), [
        PAPER.clause_text(k) for k in np.flatnonzero(often & (outcomes == 0).any(axis=1))
    ]


def scene(make, x, y, *, known=None, arena=None, physics=None, heard=(), **fields):
    """Truth of agent 0's clauses, by their words."""
    arena = arena or make.arena([(x, y), (-900, 0)], channels=(0,), width=3)
    state = make.know(make.state(arena, **fields), {(0, 1): (0, *known)} if known else {})
    links = make.links(2, heard=[(0, node) for node in heard], channels=3)
    truth = truth_table(make.see(state, links, arena, physics or make.physics()))
    return lambda words: bool(truth[PAPER.parse_clause(words), 0])


def test_distances_by_hand(make):
    holds = scene(make, 200, 0, known=(240, 0))
    assert holds("d_si < d_th")
    assert not holds("d_si > d_th")
    assert holds("d_si < net")
    assert holds("d_source > net")
    assert holds("d_sink > d_so")
    assert holds("d_source = d_so")  # the source is the only one source-side
    assert not holds("d_source < d_so")
    assert not holds("d_source > d_so")
    assert holds("d_c = d_si")


@pytest.mark.parametrize(("x", "holds_equal"), [(50, True), (48.1, True), (51.9, True), (47.9, False), (52.1, False)])
def test_equality_has_a_tolerance_of_one_step(make, x, holds_equal):
    assert scene(make, x, 0)("d_source = d_th") == holds_equal


@pytest.mark.parametrize(("x", "holds_equal"), [(163, True), (160, True), (166, True), (159, False), (167, False)])
def test_equality_has_a_tolerance_of_a_share_of_the_right_operand(make, x, holds_equal):
    """2 % of 163 m are 3.26 m."""
    assert scene(make, x, 0)("d_source = net") == holds_equal


def test_the_tolerance_is_of_the_right_operand_only(make):
    """Source-side 286 m, sink-side 300.6 m: 5 % of these are 14.3 m and 15.03 m."""
    arena = make.arena([(286, 0), (-900, 0)], sink=(586.6, 0), width=3)
    physics = make.physics(tolerance=0.05)
    holds = scene(make, 0, 0, arena=arena, physics=physics)
    assert holds("d_so = d_si")
    assert not holds("d_si = d_so")


def test_equal_and_less_may_both_hold(make):
    holds = scene(make, 49, 0)
    assert holds("d_source = d_th")
    assert holds("d_source < d_th")


@pytest.mark.parametrize(
    ("x", "less", "greater"),
    [(49.99, True, False), (49.9995, False, False), (50.0005, False, False), (50.01, False, True)],
)
def test_less_and_greater_need_more_than_rounding(make, x, less, greater):
    """Half a millimetre is none; the same distance may be computed in two ways."""
    holds = scene(make, x, 0)
    assert holds("d_source < d_th") == less
    assert holds("d_source > d_th") == greater
    assert holds("d_source = d_th")


@pytest.mark.parametrize("operator", vocabulary.OPERATORS)
def test_an_undefined_operand_makes_its_clause_false_under_every_operator(make, operator):
    """At the source nobody is source-side, and no jammer is known."""
    holds = scene(make, 0, 0)
    for right in vocabulary.RIGHT:
        assert not holds(f"d_so {operator} {right}")
    for left in vocabulary.LEFT:
        assert not holds(f"{left} {operator} d_so")
        assert not holds(f"{left} {operator} xi")


def test_the_jammers_range_once_known(make):
    arena = make.arena([(100, 0), (-900, 0)], jammer=(400, 400), width=3)
    holds = scene(make, 0, 0, arena=arena, jammer_range=[120, 0])
    assert holds("d_source < xi")
    assert holds("d_sink > xi")
    assert not holds("d_source = xi")
    assert scene(make, 0, 0, arena=arena, jammer_range=[101.9, 0])("d_source = xi")


@pytest.mark.parametrize("node", [2, 3])
def test_source_or_sink_heard_is_a_node_in_reach(make, node):
    assert scene(make, 30, 0, heard=[node])("node in reach")
    assert not scene(make, 30, 0, heard=[node])("no node in reach")
    assert scene(make, 30, 0, heard=[1])("no node in reach")


def test_noise_on_each_channel(make):
    interference = np.array([[P_RS * 1.001, 0], [P_RS * 0.999, 0], [1, 0]])
    holds = scene(make, 30, 0, interference=interference)
    assert not holds("NI <= P_rs")
    assert holds("noise on 6 <= P_rs")
    assert not holds("noise on 11 <= P_rs")


def test_at_first_only_thermal_noise_is_measured(make):
    holds = scene(make, 30, 0)
    assert holds("NI <= P_rs")
    assert holds("noise on 11 <= P_rs")


def test_a_channel_that_is_not_simulated_makes_its_clause_false(make):
    arena = make.arena([(30, 0), (-900, 0)], width=1)
    truth = truth_table(make.see(make.state(arena), make.links(2, heard=[]), arena, make.physics()))
    assert truth[PAPER.parse_clause("NI <= P_rs")].all()
    assert not truth[PAPER.parse_clause("noise on 6 <= P_rs")].any()
    assert not truth[PAPER.parse_clause("noise on 11 <= P_rs")].any()


@pytest.mark.parametrize("over", [{"t": 1000}, {"delivered": 300, "waiting": 0}])
def test_nothing_is_true_once_the_episode_is_over(make, over):
    arena = make.arena([(30, 0), (-900, 0)])
    seen = make.see(make.state(arena, **over), make.links(2), arena, make.physics())
    assert not truth_table(seen).any()
    assert not bool(seen.view.running)


def test_the_operands_are_offered_to_other_policies_too(make):
    rng = np.random.default_rng(9)
    physics = make.physics()
    state, links, arena = make.view(rng)
    seen = make.see(state, links, arena, physics)
    for i in range(5):
        view = make.plain(state, arena, links.heard, i)
        for names, table in ((vocabulary.LEFT, seen.view.left), (vocabulary.RIGHT, seen.view.right)):
            for k, name in enumerate(names):
                expected = operand(name, view, state, physics)
                assert float(table[k][i]) == pytest.approx(np.inf if expected is None else expected, rel=1e-5)


def test_figures_of_fewer_channels_are_those_that_these_have(make):
    physics = make.physics()
    state, links, arena = make.view(np.random.default_rng(3))
    view = make.see(state, links, arena, physics).view
    every = dict(zip((one.name for one in feature_list(3)), features(view), strict=True))
    for count in (1, 2):
        names = [one.name for one in feature_list(count)]
        np.testing.assert_array_equal(features(view, count), np.stack([every[name] for name in names]))
