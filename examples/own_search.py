"""A search of your own: the fittest swarm for each way of working (MAP-Elites; Mouret and Clune 2015).

python examples/own_search.py                                        # from Python
slcs2 evolve plugins=[own_search] search=niches search.batch=4 ...   # from the command line, beside this file
"""

import numpy as np

import slcs2_jax as slcs2
from slcs2_jax.search import BaseSearch, Exchange, Verdict


@slcs2.register("search", "niches")
class Niches(BaseSearch):
    """Keeps the fittest solution of each niche: how much comes through, and how many agents take part in it."""

    def __init__(self, problem):
        super().__init__(problem)
        self.vary = Exchange(problem)  # the paper's offspring; any `Variation` will do
        self.fittest = {}

    def niche(self, evaluation):
        """Tenths of the greatest contribution that agents have on average, and how many contribute at all."""
        contribution = evaluation.contribution
        return int(10 * contribution.mean() / max(contribution.max(), 1)), int(np.count_nonzero(contribution))

    @property
    def members(self):
        """What is saved when a run ends, oldest first."""
        return sorted(self.fittest.values(), key=lambda member: member.generation)

    def propose(self, generation):
        """A new solution: random at first, then a child of any of those kept."""
        members = self.members
        if len(members) < 2:
            return self.problem.random_solution(self.supply, generation)
        parent = members[self.rng.integers(len(members))]
        drawn = {"members": members, "supply": self.supply, "rng": self.rng}
        return self.vary(parent.solution, parent.evaluation, explorations=0, generation=generation, **drawn)

    def consider(self, newcomer):
        """Give the newcomer its niche if it is empty or less fit."""
        niche = self.niche(newcomer.evaluation)
        former = self.fittest.get(niche)
        if former is not None and newcomer.fitness <= former.fitness:
            return Verdict(accepted=False, size=len(self.fittest))
        self.fittest[niche] = newcomer
        return Verdict(removed=() if former is None else (former.generation,), size=len(self.fittest))

    def recall(self, members, kept):
        """Go on from a checkpoint: members, the best, and what is drawn next are kept by the machinery."""
        self.fittest = {self.niche(member.evaluation): member for member in members}


def main():
    """Evolve small swarms, four solutions at a time."""
    settings = slcs2.Settings(
        world=slcs2.World(distance=300.0, time_limit=2000),
        swarm=slcs2.Swarm(agents=6, packets=10),
        rules=slcs2.Rules(rules=40),
        search=slcs2.Search(generations=24, batch=4, fresh_deployments=4),
        instances=2,
        run_dir="run_of_niches",
    )
    [summary] = slcs2.evolve(settings, search="niches")
    for number, instance in enumerate(summary.instances):
        niches = len(slcs2.read_run("run_of_niches").members(number))
        print(f"seed {instance.seed}: {niches} niches, winner's fresh mean {instance.fresh_mean:.3f}")


if __name__ == "__main__":
    main()
