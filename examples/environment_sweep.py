"""The environment under a random policy, swept over the path-loss exponent: one program, compiled once.

    python examples/environment_sweep.py

The radio's parameters are values, so `vmap` maps over them as over keys; the network range follows by itself. Any other
number of the physics does in its place: `swarm.speed`, `radio.noise_dbm`, ...
"""

import jax
import jax.numpy as jnp

import slcs2_jax as slcs2

EXPONENTS = jnp.linspace(2.2, 3.6, 8)
EPISODES, STEPS = 8, 500

env = slcs2.make("open_short", {"swarm.agents": 12, "swarm.packets": 20})
HEARD = [feature.name for feature in env.features].index("agents heard")


def random_action(key, mask):
    """Any of the actions that could have an effect now, all alike: int [n]."""
    return jax.random.categorical(key, jnp.where(mask, 0.0, -jnp.inf))


def episode(key, exponent):
    """Some steps under one exponent: what each episode came to, by name."""
    params = env.change(env.params, {"radio.path_loss_exponent": exponent})
    key, start = jax.random.split(key)

    def step(carry, key):
        seen, state = carry
        action = random_action(key, seen.action_mask)
        seen, state, reward, _, _, info = env.step(key, state, action, params)
        return (seen, state), (reward.mean(), seen.features[:, HEARD].mean(), info["waiting"], info["delivered"])

    _, (reward, heard, waiting, delivered) = jax.lax.scan(step, env.reset(start, params), jax.random.split(key, STEPS))
    return {
        "net, m": params.physics.radio.network_range,
        "others heard": heard.mean(),
        "collected": env.settings.swarm.packets - waiting[-1],
        "delivered": delivered[-1],
        "reward": reward.mean(),
    }


def main():
    """Sweep, and print the mean of each figure over the episodes."""
    sweep = jax.jit(jax.vmap(jax.vmap(episode, (0, None)), (None, 0)))
    table = sweep(jax.random.split(jax.random.key(0), EPISODES), EXPONENTS)
    print("exponent  " + "  ".join(f"{name:>12}" for name in table))
    for row, exponent in enumerate(EXPONENTS):
        print(f"{exponent:8.2f}  " + "  ".join(f"{float(figures[row].mean()):12.3f}" for figures in table.values()))


if __name__ == "__main__":
    main()
