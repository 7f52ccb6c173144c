"""A policy of your own: a small network that all agents share, deployed like any other policy.

    python examples/own_policy_network.py

A network is a pure function and a pytree of parameters. Here the parameters are drawn, and the best of a few draws is
looked at; put in their place what your learner has learnt.
"""

import jax.numpy as jnp
import numpy as np

import slcs2_jax as slcs2

HIDDEN, DRAWS, WORLDS = 16, 4, 3

settings = slcs2.Settings(
    world=slcs2.World(distance=190.0, time_limit=1000),
    swarm=slcs2.Swarm(agents=6, packets=10),
)
grammar = slcs2.load_grammar("main")  # says which actions there are
env = slcs2.Env(settings)  # says how many figures an agent sees: `env.features` tells what each is


def network(parameters, carry, features):
    """One agent: (parameters, carry [C], features [F]) -> carry [C], a logit for each action and for doing nothing."""
    hidden = jnp.tanh(features @ parameters["w"] + parameters["b"])
    return carry, hidden @ parameters["out"]


def draw(rng):
    """Random parameters: float32 arrays in a dictionary."""
    sizes = env.spaces
    return {
        "w": rng.normal(0, 1 / np.sqrt(sizes.features), (sizes.features, HIDDEN)).astype(np.float32),
        "b": np.zeros(HIDDEN, np.float32),
        "out": rng.normal(0, 2 / np.sqrt(HIDDEN), (HIDDEN, sizes.actions)).astype(np.float32),
    }


def main():
    """Deploy a few draws in the same worlds, and print what the best one's agents did most."""
    policy = slcs2.Network.over(grammar, network, sample=True)  # actions are drawn by the logits, effective ones alone
    rng = np.random.default_rng(0)
    policies = [slcs2.bind(policy, draw(rng)) for _ in range(DRAWS)]
    found = slcs2.Evaluator(settings)(policies, range(WORLDS))  # all of them in every world, in one batch
    for number, fitness in enumerate(found.mean):
        print(f"network {number}: fitness {fitness:.3f}, {found.delivered[number].mean():.1f} packets at the sink")
    best = slcs2.replay(policies[int(np.argmax(found.mean))], settings, seed=0)
    actions, times = np.unique(best.action[best.action < len(best.vocabulary.actions)], return_counts=True)
    for place in np.argsort(-times)[:5]:
        print(f"{times[place] / best.action.size:6.1%}  {best.vocabulary.action_text(actions[place])}")


if __name__ == "__main__":
    main()
