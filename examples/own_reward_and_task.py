"""A reward and a task of your own: packets must come through before half of the time is over, and hurry is praised.

python examples/own_reward_and_task.py                                        # from Python
slcs2 evolve plugins=[own_reward_and_task] task.name=deadline task.reward=hurry ...
"""

import dataclasses

import jax.numpy as jnp

import slcs2_jax as slcs2


@slcs2.register("reward", "hurry")
@dataclasses.dataclass(frozen=True)
class Hurry:
    """1 for whoever brings a packet nearer to the sink by carrying or sending it, less a small price for every act."""

    def __call__(self, view, after, outcome):
        """float32 [n, ...]: see `slcs2_jax.swarm.reward.Reward` for what the arguments hold."""
        agents = view.x.shape[0]
        handed_on = jnp.any(outcome.air.accepted[:, :agents], axis=(0, 2))
        nearer = after.x > view.x + 0.5
        carries = view.holding & nearer
        return (handed_on | carries).astype(jnp.float32) - 0.01


@slcs2.register("task", "deadline")
@dataclasses.dataclass(frozen=True)
class Deadline(slcs2.Delivery):
    """An episode ends when half of the packets are at the sink; it scores the share of time that is left then."""

    def going_on(self, state, arena, parameters):
        """Whether packets are still under way: bool [...]."""
        return 2 * state.delivered < parameters.packets

    def fitness(self, score):
        """From 1 (at once) to 0 (in the last moment); -1 for what never came to it."""
        done = 2 * score.delivered >= score.packets
        return 1 - score.steps / score.time_limit if done else -1.0


def main():
    """Deploy random rule-sets under the task, in the open."""
    settings = slcs2.Settings(
        task=slcs2.Task(name="deadline", reward="hurry"),
        swarm=slcs2.Swarm(agents=6, packets=10),
        rules=slcs2.Rules(rules=40),
        search=slcs2.Search(generations=6, fresh_deployments=4),
        instances=2,
    )
    [summary] = slcs2.evolve(settings)
    for instance in summary.instances:
        print(f"seed {instance.seed}: best {instance.best_fitness:.3f}, fresh mean {instance.fresh_mean:.3f}")


if __name__ == "__main__":
    main()
