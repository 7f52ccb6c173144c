"""MAP-Elites over rule-sets with an archive of pyribs (`pip install ribs`), on the evaluator alone.

python examples/own_search_pyribs.py

examples/own_search.py is the other way: a search that runs inside `slcs2 evolve`, with resume and reports.
"""

import numpy as np
from ribs.archives import GridArchive

import slcs2_jax as slcs2

AGENTS, RULES, BATCH, ROUNDS = 6, 40, 8, 6
GRAMMAR = slcs2.load_grammar("main")
WORDS = GRAMMAR.vocabulary.words


def as_vector(rules):
    """Rule-sets as one row of whole numbers, as the archive keeps them."""
    return np.concatenate([rules.mask.ravel(), rules.action.ravel().astype(np.uint32)])


def as_rules(vector):
    """What `as_vector` was given."""
    masks, actions = np.split(vector.astype(np.uint32), [AGENTS * RULES * WORDS])
    return slcs2.RuleSets(masks.reshape(AGENTS, RULES, WORDS), actions.astype(np.uint8).reshape(AGENTS, RULES))


def child(parent, rng):
    """A tenth of the parent's rules anew."""
    drawn, anew = slcs2.random_rule_sets(GRAMMAR, AGENTS, RULES, rng), rng.random((AGENTS, RULES)) < 0.1
    mask = np.where(anew[..., None], drawn.mask, parent.mask)
    return slcs2.RuleSets(mask, np.where(anew, drawn.action, parent.action))


def main():
    """Six rounds of eight swarms; a swarm's niche is how many agents contribute, and how long it takes."""
    settings = slcs2.Settings(
        world=slcs2.World(distance=300.0, time_limit=2000),
        swarm=slcs2.Swarm(agents=AGENTS, packets=10),
        rules=slcs2.Rules(rules=RULES),
    )
    evaluator, rng = slcs2.Evaluator(settings), np.random.default_rng(0)
    dim = AGENTS * RULES * (WORDS + 1)
    ranges = [(0, AGENTS + 1), (0, 2000)]
    archive = GridArchive(solution_dim=dim, dims=[AGENTS + 1, 10], ranges=ranges, solution_dtype=np.uint32, seed=0)
    for number in range(ROUNDS):
        if archive.empty:
            swarms = [slcs2.random_rule_sets(GRAMMAR, AGENTS, RULES, rng) for _ in range(BATCH)]
        else:
            parents = archive.sample_elites(BATCH)["solution"]
            swarms = [child(as_rules(parent), rng) for parent in parents]
        found = evaluator(swarms, [0], deployments=2)
        carriers = (found.contribution.mean(axis=(1, 2)) > 0).sum(axis=-1)
        steps = found.steps.mean(axis=(1, 2))
        archive.add(np.stack([as_vector(one) for one in swarms]), found.mean, np.stack([carriers, steps], axis=1))
        best = archive.stats.obj_max
        print(f"round {number}: {len(archive)} niches, best fitness {best:.3f}")


if __name__ == "__main__":
    main()
