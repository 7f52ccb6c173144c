"""What a step brought, before it is rewarded."""

from __future__ import annotations

import dataclasses

import jax

from slcs2_jax.swarm.intent import Intent
from slcs2_jax.swarm.packets import Air


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Outcome:
    """What everybody was about, and what became of the transmissions."""

    intent: Intent
    air: Air
