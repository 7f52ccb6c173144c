"""One rule-set for all agents, or one for each? The same search with the same episodes, both ways.

python examples/homogeneous_swarms.py
slcs2 evolve -m search.homogeneous=false,true search.episodes=200 ...
"""

import slcs2_jax as slcs2


def main():
    """Evolve small swarms both ways, all in one batch, and compare the winners in worlds that they have not seen."""
    kinds = {"heterogeneous": False, "homogeneous": True}
    settings = [
        slcs2.Settings(
            world=slcs2.World(distance=300.0, time_limit=2000),
            swarm=slcs2.Swarm(agents=6, packets=10),
            rules=slcs2.Rules(rules=40),
            search=slcs2.Search(homogeneous=homogeneous, generations=60, episodes=60, fresh_deployments=4),
            instances=2,
            run_dir=f"run_{kind}",
        )
        for kind, homogeneous in kinds.items()
    ]
    summaries = slcs2.evolve(*settings)
    winners = {kind: slcs2.read_run(summary.run_dir).best(0) for kind, summary in zip(kinds, summaries, strict=True)}
    evaluator = slcs2.Evaluator(settings[0])
    elsewhere = evaluator(list(winners.values()), range(100, 104), deployments=2)
    for (kind, winner), summary, fitness in zip(winners.items(), summaries, elsewhere.mean, strict=True):
        rules = len({winner.rules.text(agent, rule) for agent in range(6) for rule in range(40)})
        fresh = sum(instance.fresh_mean for instance in summary.instances) / len(summary.instances)
        print(f"{kind}: {rules} different rules, fresh mean {fresh:.3f}, in unseen worlds {fitness:.3f}")


if __name__ == "__main__":
    main()
