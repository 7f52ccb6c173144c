from __future__ import annotations

import numpy as np

from slcs2_jax.search import FewestExplorations


def test_parents_are_the_least_explored_and_newest(make):
    members = [make.member(0.0, [[number]], number) for number in range(3)]
    choose, rng = FewestExplorations(make.problem()), np.random.default_rng(0)
    order = []
    for _ in range(7):
        member = choose(members, rng)
        order.append((member.generation, member.explorations))
        member.explorations += 1
    assert order == [(2, 0), (1, 0), (0, 0), (2, 1), (1, 1), (0, 1), (2, 2)]
    members.append(make.member(0.0, [[8]], 3))
    for generation in (3, 3, 3, 1):
        member = choose(members, rng)
        assert member.generation == generation
        member.explorations += 1
    assert rng.bit_generator.state == np.random.default_rng(0).bit_generator.state, "nothing is drawn"
