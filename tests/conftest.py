"""Strictness for every test: JAX on two CPU devices, no silent promotion of dtypes; and see pyproject.toml.

And builders of small solutions, deployments, evaluations and searches. n agents, R rules.
"""

import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import shutil

import hypothesis
import jax
import numpy as np
import pytest

from slcs2_jax.config import Search as SearchSettings
from slcs2_jax.results.figures import Figures
from slcs2_jax.search import Deployment, Evaluation, Member, Problem, RuleSupply, Slcs2, Solution, mean_of

jax.config.update("jax_num_cpu_devices", 2)
jax.config.update("jax_numpy_dtype_promotion", "strict")
# Ranks may differ on purpose: the batch is the last axis and [B] meets [n, B].

hypothesis.settings.register_profile("slcs2", deadline=None, max_examples=50, print_blob=True)
hypothesis.settings.load_profile("slcs2")


class Make:
    """Builders; every argument left out gets something valid."""

    @staticmethod
    def source(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Random rules of one or two clauses of 97 and an action of 57."""
        clause = rng.integers(0, 97, (count, 2))
        mask = np.zeros((count, 4), np.uint32)
        for column in clause.T:
            mask[np.arange(count), column // 32] |= np.left_shift(np.uint32(1), (column % 32).astype(np.uint32))
        return mask, rng.integers(0, 57, count, dtype=np.uint8)

    @staticmethod
    def supply(seed: int = 0) -> RuleSupply:
        return RuleSupply(Make.source, np.random.SeedSequence(seed))

    @staticmethod
    def solution(
        ids: np.ndarray | None = None, *, agents: int = 2, rules: int = 4, generation: int = 0, seed: int = 0
    ) -> Solution:
        """A random solution; rules of equal `ids` are made equal, so that sharing of rules can be written down."""
        if ids is not None:
            agents, rules = np.shape(ids)
        drawn = Make.problem(agents=agents, rules=rules).random_solution(Make.supply(seed), 0)
        arrays = {name: array.copy() for name, array in drawn.arrays().items()}
        if ids is not None:
            arrays["mask"][..., 0] = np.asarray(ids) + 1  # a rule has a clause
            arrays["mask"][..., 1:], arrays["action"][:] = 0, 0
        return Solution.of(arrays | {"generation": generation, "parent": -1})

    @staticmethod
    def deployment(
        fitness: float = -0.5,
        contribution: Sequence[int] = (0, 0),
        *,
        rules: int = 4,
        rng: np.random.Generator | None = None,
        **fields: np.ndarray,
    ) -> Deployment:
        """Arrays of zeros (usage: ones), random ones if `rng` is given, or those given."""
        shape = (len(contribution), rules)
        names = ("quality", "strength", "error")
        arrays = {name: np.zeros(shape) if rng is None else rng.normal(size=shape) for name in names}
        arrays["usage"] = np.ones(shape) if rng is None else rng.integers(0, 3, shape)
        arrays |= fields
        return Deployment(
            fitness=fitness,
            delivered=3,
            steps=100,
            contribution=np.array(contribution, np.int64),
            figures=Figures(
                usage=np.asarray(arrays["usage"], np.int32),
                **{name: np.asarray(arrays[name], np.float32) for name in names},
            ),
        )

    @staticmethod
    def evaluation(*args, **kwargs) -> Evaluation:
        """The evaluation of one such deployment."""
        return mean_of([Make.deployment(*args, **kwargs)])

    @staticmethod
    def member(fitness: float, ids: Sequence[Sequence[int]], generation: int, explorations: int = 0) -> Member:
        """A member with this fitness, rule ids and generation."""
        solution = Make.solution(np.array(ids), generation=generation)
        agents, rules = solution.shape
        evaluation = Make.evaluation(fitness, (0,) * agents, rules=rules)
        return Member(solution, evaluation, explorations)

    @staticmethod
    def problem(*, agents: int = 3, rules: int = 8, seed: int = 7, **settings) -> Problem:
        """An instance under the default settings but for those given."""
        return Problem(settings=SearchSettings(**settings), agents=agents, rules=rules, seed=seed, source=Make.source)

    @staticmethod
    def search(*, kind=Slcs2, **values):
        """A search for `problem` with these values."""
        return kind(Make.problem(**values))


@pytest.fixture(scope="session")
def make() -> type[Make]:
    return Make


@pytest.fixture(autouse=True, scope="module")
def _programs_are_dropped():
    """What one file's tests compiled the next one's seldom need, and all of it together takes gigabytes."""
    yield
    jax.clear_caches()


@pytest.fixture(scope="session")
def readers_cache(tmp_path_factory) -> Path:
    """The cache folder of whoever follows the documentation: empty at first, then with what was compiled."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="session")
def browser():
    """A real browser, for all tests of pages: CHROMIUM names one. Without any they are skipped, unless
    SLCS2_BROWSER=required."""
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None and os.environ.get("SLCS2_BROWSER") != "required":
        pytest.skip("needs Chromium")
    from playwright import sync_api

    flags = ["no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking"]
    flags += ["disable-component-update", "disable-sync"]
    with sync_api.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=chromium, args=[f"--{flag}" for flag in flags])
        yield started
        started.close()
