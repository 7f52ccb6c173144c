"""A clause, a move target and an action of your own, with a grammar that says them: one file, nothing edited inside.

python examples/own_clause_and_action.py                                     # from Python
slcs2 evolve plugins=[own_clause_and_action] grammar=crowd.bnf ...           # from the command line, beside this file
"""

import jax.numpy as jnp

import slcs2_jax as slcs2


@slcs2.register("clause", "in a crowd")
def in_a_crowd(view):
    """Whether at least three other agents are known to be within 30 m: bool [n, ...]."""
    near = view.everybody.known & (view.everybody.squared < 30.0**2)
    agents = view.x.shape[0]
    return jnp.sum(near[:agents].astype(jnp.int32), axis=0) >= 3


@slcs2.register("move target", "middle")
def middle(view):
    """Half-way to where the agents believe the sink to be: x, y in m, and whether it is known."""
    x = jnp.broadcast_to(view.arena.estimate_x / 2, view.x.shape)
    return x, jnp.zeros_like(x), jnp.ones_like(x, bool)


@slcs2.register("action", "whisper to sink")
def whisper(view):
    """Send to the sink at a tenth of full power: node n + 1 is the sink."""
    return slcs2.send(view, view.x.shape[0] + 1, level=0.1)


GRAMMAR = """
<Rule>      ::= <Condition> => <Action>
<Condition> ::= <Condition> & <Condition> | in a crowd | packet held | no packet held | d_sink "<" net
<Action>    ::= move <Direction> <Target> | collect from source | send to si | whisper to sink
<Direction> ::= toward | away from | orbit
<Target>    ::= si | sink | source | middle
"""


def main():
    """Evolve a small swarm that may say these things, and print what its strongest rules are."""
    with open("crowd.bnf", "w", encoding="utf-8") as file:
        file.write(GRAMMAR)
    settings = slcs2.Settings(
        rules=slcs2.Rules(grammar="crowd.bnf", rules=40),
        swarm=slcs2.Swarm(agents=6, packets=20),
        search=slcs2.Search(generations=4, fresh_deployments=2),
        instances=2,
        run_dir="crowd_run",
    )
    [summary] = slcs2.evolve(settings)
    print(f"fresh means {[round(instance.fresh_mean, 3) for instance in summary.instances]}")
    best = slcs2.load_solution("crowd_run/solutions/instance_000_best.npz")
    print("\n".join(best.text().splitlines()[:8]))


if __name__ == "__main__":
    main()
