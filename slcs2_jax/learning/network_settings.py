"""What the network is that a training begins with."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from slcs2_jax.config.field import Section, refuse, setting
from slcs2_jax.config.settings import Settings
from slcs2_jax.grammar import Grammar
from slcs2_jax.policy.bound import BoundPolicy, bind
from slcs2_jax.policy.trained_network import NAME, initial_parameters
from slcs2_jax.search.keys import PURPOSE_NETWORK, seed_sequence

MOST_WEIGHTS = 2**23  # of the layers among themselves: 32 MiB, so that what a training keeps can be read at once


@dataclass(frozen=True)
class NetworkSettings(Section):
    """Sizes of the network that all agents share, and how they act by it."""

    SECTION = "network"

    hidden: tuple[int, ...] = setting(
        (64, 64),
        "widths of the layers, tanh behind each",
        unit="units",
        status="run",
        fewest=1,
        most=8,
        low=1,
        high=4096,
    )
    recurrent: int = setting(
        0, "units of a GRU behind the layers, its memory; 0 for none", unit="units", status="run", low=0, high=4096
    )
    sampled: bool = setting(
        True, "draw an agent's action by the logits, trained and deployed alike; off takes the greatest", status="run"
    )

    def cross_check(self) -> None:
        last = self.hidden[-1]
        weights = sum(a * b for a, b in itertools.pairwise(self.hidden)) + 3 * self.recurrent * (last + self.recurrent)
        if weights > MOST_WEIGHTS:
            accepted = f"widths with at most {MOST_WEIGHTS:,} weights between them and network.recurrent; these have"
            raise refuse("network.hidden", self.hidden, f"{accepted} {weights:,}")

    def start(self, settings: Settings, seed: int) -> BoundPolicy:
        """The network that the training of this seed begins with, for the actions of the settings' grammar."""
        rng = np.random.Generator(np.random.PCG64(seed_sequence(seed, PURPOSE_NETWORK)))
        return bind(NAME, initial_parameters(
            Grammar.of(settings), rng, hidden=self.hidden, recurrent=self.recurrent, sampled=self.sampled
        ))  # fmt: skip
