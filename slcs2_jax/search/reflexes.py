"""Which rules of knowledge are an agent's reflexes: flags that evolve gently. n = agents, K = rules of knowledge."""

from __future__ import annotations

import numpy as np

from slcs2_jax.search.solution import Solution

_FEW = 3  # one agent in so many, at least one


def mutate_flags(flags: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The flags bool[n, K] after one small change, each of three as likely as the others:

    one rule is switched in the whole swarm, to what it is not in an agent drawn; one rule is switched in a few agents,
    1 to n / 3; or one agent takes the flags of another, or has a rule switched if those are its own. An agent alone
    has a rule switched. The result is never what it was.
    """
    agents, rules = flags.shape
    changed = flags.copy()
    kind = int(rng.integers(3)) if agents > 1 else 0
    rule, agent = int(rng.integers(rules)), int(rng.integers(agents))
    if kind == 0:
        changed[:, rule] = not flags[agent, rule]
    elif kind == 1:
        some = rng.permutation(agents)[: int(rng.integers(1, max(1, agents // _FEW) + 1))]
        changed[some, rule] = ~flags[some, rule]
    else:
        changed[agent] = flags[(agent + int(rng.integers(1, agents))) % agents]
        if (changed == flags).all():
            changed[agent, rule] = not flags[agent, rule]
    return changed


def with_flags(solution: Solution, flags: np.ndarray) -> Solution:
    """The solution with these reflexes bool[n, K] among its first rules, and no other."""
    reflex = np.zeros(solution.shape, bool)
    reflex[:, : flags.shape[1]] = flags
    return Solution.of(solution.values() | {"reflex": reflex}, solution.rules.vocabulary)
