"""Settings of IPPO."""

from __future__ import annotations

from dataclasses import dataclass, field

from slcs2_jax.config.errors import refuse
from slcs2_jax.config.field import LEAST, Section, setting
from slcs2_jax.learning.network_settings import NetworkSettings


@dataclass(frozen=True)
class Ippo(Section):
    """How IPPO learns. An update looks at `chunk` steps of `episodes` episodes, of each of their agents."""

    SECTION = "ippo"

    network: NetworkSettings = field(default_factory=NetworkSettings)
    episodes: int = setting(128, "episodes side by side", status="run", low=1, high=65_536)
    chunk: int = setting(
        200, "steps of each between updates, whole sharing periods", unit="steps", status="run", low=1, high=100_000
    )
    stagger: int = setting(
        4000, "the first of each slot's episodes are cut, at times spread evenly over this, so that slots do not march "
        "in step: about as long as an episode takes a good swarm", unit="steps", status="run", low=1, high=10**7,
    )  # fmt: skip
    unroll: int = setting(
        20, "steps that a recurrent network is trained through at a time; a divisor of chunk", unit="steps",
        status="run", low=1, high=100_000,
    )  # fmt: skip
    learning_rate: float = setting(1e-3, "Adam's", status="run", low=0, high=1)
    anneal: int | None = setting(
        None, "env-steps in which the learning rate falls to 0, linearly; null keeps it", unit="env-steps",
        status="run", low=1, high=10**15,
    )  # fmt: skip
    gradient_norm: float = setting(0.5, "greatest norm of a gradient", status="run", low=LEAST, high=1e6)
    discount: float = setting(0.997, "gamma, per step", status="run", low=0, high=1)
    gae: float = setting(0.95, "lambda of the advantage estimate", status="run", low=0, high=1)
    clip: float = setting(0.2, "how far a probability ratio counts from 1", status="run", low=LEAST, high=1)
    entropy: float = setting(0.01, "weight of the entropy", status="run", low=0, high=10)
    value: float = setting(0.5, "weight of the value's error", status="run", low=0, high=100)
    value_decay: float = setting(
        0.99, "what remains of the running mean and variance of returns in an update", status="run", low=0, high=1,
        high_open=True,
    )  # fmt: skip
    epochs: int = setting(2, "times that an update goes through its data", status="run", low=1, high=100)
    minibatches: int = setting(16, "gradient steps in each", status="run", low=1, high=10_000)
    share: float = setting(
        0.25, "share of the data that each goes through, drawn anew: steps side by side are much alike", status="run",
        low=LEAST, high=1,
    )  # fmt: skip
    snapshot: int = setting(
        1_000_000, "keep the policy whenever so many env-steps more are done", unit="env-steps", status="run",
        low=1, high=10**12,
    )  # fmt: skip

    def cross_check(self) -> None:
        if self.chunk % self.unroll:
            raise refuse("ippo.unroll", self.unroll, f"a divisor of ippo.chunk={self.chunk}")
        if not self.network.sampled:
            raise refuse("network.sampled", False, "true with IPPO, which learns from what it draws")
