"""What asks for deployments, and the simplest of it: a policy deployed so many times."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from slcs2_jax.config import Settings
from slcs2_jax.policy.bound import BoundPolicy
from slcs2_jax.rollout import Done, Job
from slcs2_jax.running.deployable import deployment_of, job_of
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.keys import Key, fresh_deployment_key
from slcs2_jax.swarm.task import Delivery, task_of
from slcs2_jax.world.scenario import Scenario

Name = tuple[str, int, int]  # stage, generation, deployment


@dataclass(frozen=True, eq=False)
class Site:
    """Where a task's deployments take place, by turns, and how they are scored.

    seed: of the task; deployments with fresh randomness follow from it. settings: whose physical values they have.
    """

    scenarios: tuple[Scenario, ...]
    seed: int
    packets: int
    task: Delivery
    settings: Settings

    @classmethod
    def of(cls, scenario: Scenario, settings: Settings) -> Site:
        """A scenario, with the packets, the task and the physics of the settings."""
        return cls((scenario,), scenario.seed, settings.swarm.packets, task_of(settings), settings)

    @property
    def scenario(self) -> Scenario:
        """The first."""
        return self.scenarios[0]

    def job(self, name: Name, policy: BoundPolicy, key: Key) -> Job:
        """One deployment of a policy here."""
        return job_of(policy, name, self.scenarios[name[2] % len(self.scenarios)], key, self.settings)

    def score(self, done: Done) -> Deployment:
        """What a deployment here measured."""
        return deployment_of(done, self.packets, self.task)


class Task(Protocol):
    """Something that needs deployments until it is finished."""

    site: Site

    @property
    def policy(self) -> BoundPolicy:
        """What it deploys now; whatever it deploys later is of the same size and made of the same words."""
        ...

    @property
    def finished(self) -> bool:
        """Whether nothing more is needed."""
        ...

    @property
    def expected_fitness(self) -> float:
        """The fitness to expect: the greater, the likelier deployments beyond the certain ones are to count."""
        ...

    @property
    def generation(self) -> int:
        """How far it has come, for a task whose deployments depend on earlier ones."""
        ...

    @property
    def useful_steps(self) -> int:
        """Time-steps of the deployments that counted so far."""
        ...

    def wanted(self, ahead: int) -> list[Name]:
        """Deployments not yet taken: those certain to count and up to ``ahead`` more that may."""
        ...

    def wants(self, name: Name) -> bool:
        """May this deployment still count?"""
        ...

    def job(self, name: Name) -> Job:
        """What to compute for a wanted deployment."""
        ...

    def take(self, name: Name, done: Done) -> None:
        """Receive a wanted deployment."""
        ...


@dataclass(eq=False)
class Measurement:
    """A policy deployed again and again on one site, with fresh randomness."""

    site: Site
    policy: BoundPolicy
    count: int
    taken: dict[int, Deployment] = field(default_factory=dict)

    @property
    def finished(self) -> bool:
        """All deployments are in."""
        return len(self.taken) == self.count

    @property
    def expected_fitness(self) -> float:
        """Nothing is speculative here."""
        return 0.0

    @property
    def generation(self) -> int:
        """None of its deployments depends on another."""
        return 0

    @property
    def deployments(self) -> list[Deployment]:
        """Those taken, in order."""
        return [self.taken[index] for index in sorted(self.taken)]

    @property
    def useful_steps(self) -> int:
        """Time-steps of those taken: all count."""
        return sum(deployment.steps for deployment in self.taken.values())

    def wanted(self, ahead: int) -> list[Name]:
        """All that are missing; they are all certain."""
        return [("fresh", 0, index) for index in range(self.count) if index not in self.taken]

    def wants(self, name: Name) -> bool:
        """Is it missing?"""
        return name[0] == "fresh" and name[2] not in self.taken

    def job(self, name: Name) -> Job:
        """One fresh deployment."""
        return self.site.job(name, self.policy, fresh_deployment_key(self.site.seed, name[2]))

    def take(self, name: Name, done: Done) -> None:
        """Receive one."""
        deployment = self.site.score(done)
        deployment.check(f"seed {self.site.seed}, fresh deployment {name[2]}")
        self.taken[name[2]] = deployment
