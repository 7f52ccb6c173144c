"""Fading of your own: a link is blocked now and then, as by people who walk through it.

python examples/own_fading.py                                                     # from Python
slcs2 evaluate policy=designed plugins=[own_fading] radio.fading=passers_by ...   # from the command line
"""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

import slcs2_jax as slcs2
from slcs2_jax.world.randomness import normal, uniform

BLOCKED, LOSS_DB = 0.2, 15.0  # share of the steps, and what a passer-by takes


@slcs2.register("fading", "passers_by")
@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class PassersBy:
    """Log-normal shadowing, and in a share of the steps a loss on top; drawn for every link and step."""

    sigma: jax.Array  # log2 units
    loss: jax.Array  # log2 units

    @classmethod
    def of(cls, radio):
        """The parameters from the settings: radio.shadowing_db is the paper's sigma."""
        to_log2 = np.log2(10.0) / 10.0
        return cls(jnp.float32(radio.shadowing_db * to_log2), jnp.float32(LOSS_DB * to_log2))

    def gain(self, words):
        """log2 of each link's gain in power; words(k) is the k-th uniform word of every link."""
        blocked = uniform(words(1)) < BLOCKED
        return self.sigma * normal(words(0)) - jnp.where(blocked, self.loss, np.float32(0))


def main():
    """The designed behaviour under each kind of fading."""
    designed = slcs2.load_decision_list("designed")
    for fading in ("none", "lognormal", "rayleigh", "passers_by"):
        settings = slcs2.Settings(radio=slcs2.Radio(fading=fading), instances=4)
        summary = slcs2.evaluate(settings, designed)
        print(f"{fading:12} mean fitness {summary.mean:.3f} over {len(summary.scenarios)} worlds")


if __name__ == "__main__":
    main()
