"""A jammer of your own: it circles where it was put, and transmits in bursts once it has heard somebody.

python examples/own_jammer.py                                                                # from Python
slcs2 evaluate policy=designed environment=jammed plugins=[own_jammer] \
    jammers.motion=circle jammers.emission=bursts ...                                        # from the command line
"""

import jax.numpy as jnp
import numpy as np

import slcs2_jax as slcs2
from slcs2_jax.world.emission import SILENT, in_use

RADIUS = 40.0  # m


@slcs2.register("jammer motion", "circle")
def circle(wandering):
    """Round the place of its start at its speed: float32 [J, ...] twice, m."""
    angle = wandering.speed / RADIUS * (wandering.t + np.int32(1)).astype(jnp.float32)
    return wandering.route_x[0] + RADIUS * jnp.sin(angle), wandering.route_y[0] + RADIUS * (1 - jnp.cos(angle))


@slcs2.register("emission", "bursts")
def bursts(listening):
    """Every second interval of `dwell` steps, on the first channel in use, if it hears anything: int32 [J, ...]."""
    burst = listening.t // listening.dwell % np.int32(2) == 0
    first = in_use(listening.channels, jnp.zeros_like(listening.dwell))
    return jnp.where(listening.hears & burst, first, SILENT)


def main():
    """The designed behaviour against the paper's jammer, and against three of these."""
    designed = slcs2.load_decision_list("designed")
    for name, jammers in {
        "the paper's": slcs2.Jammers(),
        "three of mine": slcs2.Jammers(count=3, motion="circle", emission="bursts", dwell=25),
    }.items():
        world = slcs2.World.preset("jammed", "short")
        settings = slcs2.Settings(world=world, jammers=jammers, instances=4)
        summary = slcs2.evaluate(settings, designed)
        print(f"{name:14} mean fitness {summary.mean:.3f} over {len(summary.scenarios)} worlds")


if __name__ == "__main__":
    main()
