"""Evaluation of a solution: how many deployments count, and their means (spec 7; paper, Evaluation and Re-Evaluation).

[n, R] = agents, rules. Deployments are numbered 0, 1, ... and may be computed side by side and arrive in any order;
which of them count does not depend on that, so speculation never changes a result.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slcs2_jax.config import InputError

# Purposes: each gives the random numbers of one use their own stream under the same run seed.
PURPOSE_SEARCH, PURPOSE_DEPLOYMENT, PURPOSE_FRESH, PURPOSE_RULES = 1, 2, 3, 4


def seed_sequence(seed: int, *words: int) -> np.random.SeedSequence:
    """The stream of `seed` (0 <= seed < 2^64) for the given words (each below 2^32), the first of which is a purpose.

    The words go in as a spawn key: as plain entropy a long seed would run into them ([2^32, 5] equals [0, 1, 5]).
    """
    if not 0 <= seed < 2**64:
        raise InputError(f"seed = {seed}; 0 to 2^64 - 1 is accepted")
    return np.random.SeedSequence(seed, spawn_key=words)


def _key(seed: int, *words: int) -> tuple[np.uint32, np.uint32]:
    key0, key1 = seed_sequence(seed, *words).generate_state(2, np.uint32)
    return key0, key1


def deployment_key(seed: int, generation: int, deployment: int) -> tuple[np.uint32, np.uint32]:
    """Episode key of one deployment of a generation's solution in the run with this seed."""
    return _key(seed, PURPOSE_DEPLOYMENT, generation, deployment)


def fresh_deployment_key(seed: int, deployment: int) -> tuple[np.uint32, np.uint32]:
    """Episode key of one of the winner's fresh deployments; no search ever uses these."""
    return _key(seed, PURPOSE_FRESH, deployment)


@dataclass(frozen=True, eq=False, kw_only=True)
class Deployment:
    """What one episode of a solution measured."""

    fitness: float  # p_s / p - T_s / T
    delivered: int  # packets at the sink, p_s
    steps: int  # time-steps done, T_s
    contribution: np.ndarray  # int[n] delivered packets that the agent had held
    quality: np.ndarray  # float32[n, R] q at the end
    strength: np.ndarray  # float32[n, R] zeta, already divided by usage
    error: np.ndarray  # float32[n, R] epsilon
    usage: np.ndarray  # int32[n, R] tau, time-steps in an action set

    def check(self, name: str = "deployment") -> None:
        """Raise InputError naming field, agent and rule where a shape is wrong or a number not finite or negative."""
        if not np.isfinite(self.fitness):
            raise InputError(f"{name}: fitness is {self.fitness}; a finite number is required")
        shape = self.strength.shape
        if len(shape) != 2:
            raise InputError(f"{name}: strength has shape {shape}; [agents, rules] is required")
        for field in ("quality", "strength", "error", "usage", "contribution"):
            array = np.asarray(getattr(self, field))
            expected = shape[:1] if field == "contribution" else shape
            if array.shape != expected:
                raise InputError(f"{name}: {field} has shape {array.shape}; {expected} is required")
            bad = ~np.isfinite(array)
            if field in ("usage", "contribution"):
                bad |= array < 0
            if bad.any():
                agent, *rule = np.argwhere(bad)[0]
                place = f"agent {agent}" + (f", rule {rule[0]}" if rule else "")
                raise InputError(
                    f"{name}: {field} of {place} is {array[(agent, *rule)]}; finite numbers are required"
                    + (", none below 0" if field in ("usage", "contribution") else "")
                )


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluation:
    """Means over the deployments that count. Contributions are kept as sums: comparing integers is exact."""

    fitnesses: tuple[float, ...]  # of each deployment, in order
    delivered: float  # mean packets at the sink
    steps: float  # mean time-steps
    contribution_sum: np.ndarray  # int64[n] summed over the deployments
    quality: np.ndarray  # float32[n, R] mean
    strength: np.ndarray  # float32[n, R] mean
    error: np.ndarray  # float32[n, R] mean
    usage: np.ndarray  # float32[n, R] mean

    @property
    def deployments(self) -> int:
        return len(self.fitnesses)

    @property
    def fitness(self) -> float:
        """Mean fitness."""
        return sum(self.fitnesses) / len(self.fitnesses)

    @property
    def contribution(self) -> np.ndarray:
        """float64[n] mean contribution of each agent."""
        return self.contribution_sum / self.deployments

    @property
    def used(self) -> np.ndarray:
        """bool[n, R] rules that were in an action set in any deployment."""
        return self.usage > 0

    def check(self, agents: int, rules: int, name: str = "evaluation") -> None:
        """Raise InputError if it does not fit a solution of `agents` x `rules`, or if it is not finite."""
        if not self.fitnesses:
            raise InputError(f"{name}: no deployment; at least one is required")
        if self.strength.shape != (agents, rules):
            raise InputError(f"{name}: strength has shape {self.strength.shape}; ({agents}, {rules}) is required")
        one = Deployment(
            fitness=self.fitness,
            delivered=0,
            steps=0,
            contribution=self.contribution_sum,
            quality=self.quality,
            strength=self.strength,
            error=self.error,
            usage=self.usage,
        )
        one.check(name)


def mean_of(deployments: Sequence[Deployment]) -> Evaluation:
    """The evaluation in which exactly these deployments count."""
    if not deployments:
        raise InputError("deployments: none given; at least one is required")

    def mean(field: str) -> np.ndarray:
        stack = np.stack([getattr(one, field) for one in deployments])
        return stack.mean(axis=0, dtype=np.float64).astype(np.float32)

    count = len(deployments)
    return Evaluation(
        fitnesses=tuple(float(one.fitness) for one in deployments),
        delivered=sum(int(one.delivered) for one in deployments) / count,
        steps=sum(int(one.steps) for one in deployments) / count,
        contribution_sum=np.stack([one.contribution for one in deployments]).sum(axis=0, dtype=np.int64),
        quality=mean("quality"),
        strength=mean("strength"),
        error=mean("error"),
        usage=mean("usage"),
    )


def counted(fitnesses: Sequence[float], *, min_deployments: int, max_redeployments: int) -> int | None:
    """How many of the first deployments count, None if more are needed.

    Deployments go on while fewer than `min_deployments` were made, or the mean fitness is > 0 and fewer than
    `max_redeployments` re-deployments (all but the first) were made.
    """
    total = 0.0
    for count, fitness in enumerate(fitnesses, start=1):
        total += fitness
        if count >= min_deployments and (total <= 0 or count > max_redeployments):
            return count
    return None


class Trial:
    """One solution's evaluation under way: takes deployments by number in any order, says which are still wanted."""

    def __init__(self, *, min_deployments: int = 1, max_redeployments: int = 5, name: str = "evaluation") -> None:
        """`name` opens the error messages, e.g. 'run 3, generation 12'."""
        if min_deployments < 1 or max_redeployments < 0:
            raise InputError(
                f"min_deployments = {min_deployments}, max_redeployments = {max_redeployments}; "
                "at least 1 and at least 0 are accepted"
            )
        self._min, self._max_re, self._name = min_deployments, max_redeployments, name
        self._held: dict[int, Deployment] = {}

    @property
    def limit(self) -> int:
        """The greatest number of deployments that can count."""
        return max(self._min, self._max_re + 1)

    @property
    def held(self) -> dict[int, Deployment]:
        """Those handed in so far, by number."""
        return dict(self._held)

    def add(self, index: int, deployment: Deployment) -> None:
        """Hand in deployment `index`; it is ignored if beyond the count. Raises InputError on NaN or a wrong index."""
        if index in self._held or not 0 <= index < self.limit:
            raise InputError(f"{self._name}: deployment {index} is here already or is not one of 0..{self.limit - 1}")
        deployment.check(f"{self._name}, deployment {index}")
        self._held[index] = deployment

    def _prefix(self) -> list[Deployment]:
        prefix: list[Deployment] = []
        while len(prefix) in self._held:
            prefix.append(self._held[len(prefix)])
        return prefix

    def _count(self) -> int | None:
        fitnesses = [one.fitness for one in self._prefix()]
        return counted(fitnesses, min_deployments=self._min, max_redeployments=self._max_re)

    @property
    def complete(self) -> bool:
        """True once it is decided which deployments count and all of them are here."""
        return self._count() is not None

    def wanted(self, ahead: int = 0) -> list[int]:
        """Numbers not handed in yet: those certain to count, and up to `ahead` more that may count (speculation)."""
        if self.complete:
            return []
        made = len(self._prefix())
        stop = min(self.limit, max(made + 1, self._min) + ahead)
        return [index for index in range(made, stop) if index not in self._held]

    def result(self) -> Evaluation:
        """The means over the deployments that count. Raises InputError while `complete` is False."""
        count = self._count()
        if count is None:
            raise InputError(f"{self._name}: deployments {self.wanted()} are still wanted")
        return mean_of([self._held[index] for index in range(count)])
