"""Parameters of choice and learning (model section 6)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import optax

from slcs2_jax.config import Learning


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class LearningParameters:
    """Every leaf a float32 scalar; ``bp_max`` gives shapes and is static."""

    alpha_grasp: jax.Array
    alpha_q: jax.Array
    alpha_q_final: jax.Array
    beta_q: jax.Array
    trace_decay: jax.Array
    initial_quality: jax.Array
    bp_max: int = dataclasses.field(metadata={"static": True})

    @classmethod
    def of(cls, learning: Learning) -> LearningParameters:
        """Take the values from the settings; without a final learning rate it stays constant."""
        final = learning.alpha_q if learning.alpha_q_final is None else learning.alpha_q_final
        return cls(
            alpha_grasp=jnp.float32(learning.alpha_grasp),
            alpha_q=jnp.float32(learning.alpha_q),
            alpha_q_final=jnp.float32(final),
            beta_q=jnp.float32(learning.beta_q),
            trace_decay=jnp.float32(learning.trace_decay),
            initial_quality=jnp.float32(learning.initial_quality),
            bp_max=learning.bp_max,
        )

    def alpha(self, share: jax.Array) -> jax.Array:
        """alpha_q after a share of the time limit (float32 [...], 0..1): linearly from first to final value."""
        return optax.linear_schedule(self.alpha_q, self.alpha_q_final, 1)(share)
