"""Solutions that are deployed again, each time a generation of its own, whose deployments join the earlier ones."""

from __future__ import annotations

from slcs2_jax.search.evaluation import together
from slcs2_jax.search.member import Member
from slcs2_jax.search.solution import Solution


def again(solution: Solution, generation: int) -> Solution:
    """The same once more; its parent is the solution that is deployed again."""
    values = solution.values() | {"generation": generation, "parent": solution.generation}
    return Solution.of(values, solution.rules.vocabulary)


def joined(members: list[Member], newcomer: Member) -> list[Member]:
    """The members, of which one has the newcomer's deployments, too: the one that was deployed again."""
    found = list(members)
    for place, member in enumerate(members):
        if member.generation == newcomer.solution.parent:
            evaluation = together(member.evaluation, newcomer.evaluation)
            found[place] = Member(member.solution, evaluation, member.explorations)
    return found
