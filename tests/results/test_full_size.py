"""No limit refuses a run of the full size: 500 generations of 240 instances, 64 agents with 1000 rules each."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slcs2_jax.config import Rules, Search, Settings, Swarm, World
from slcs2_jax.grammar import load_grammar, random_rules
from slcs2_jax.grammar.ruleset import RuleSets
from slcs2_jax.results import InstanceSummary, RunFolder, RunSummary, SavedSolution, load_solution, read_run
from slcs2_jax.results.figures import Figures
from slcs2_jax.results.reading import ended
from slcs2_jax.results.rows import LONGEST_ROW, row_line
from slcs2_jax.results.run_folder import GENERATIONS
from slcs2_jax.results.sweep import runs_below, write_sweep
from slcs2_jax.results.watching import Watcher
from slcs2_jax.running.memory import check_rows
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.packing import pack_deployments

AGENTS, RULES, INSTANCES, GENERATIONS_MADE = 64, 1000, 240, 500
CHANCE = np.random.default_rng(0)


def full_size(run_dir=None, **values) -> Settings:
    settings = Settings(
        world=World.preset("urban_jammed", "long"),
        swarm=Swarm(agents=AGENTS, clearance=0.5),
        rules=Rules(rules=RULES),
        search=Search(generations=GENERATIONS_MADE),
        instances=INSTANCES,
        run_dir=None if run_dir is None else str(run_dir),
    )
    return dataclasses.replace(settings, **values)


def row(generation: int, instance: int) -> dict:
    """As long as a row can be."""
    long = 123456.0 / 7
    names = ("fitness", "delivered", "steps", "best", "novelty")
    counts = ("deployments", "best_generation", "size", "removed", "parent", "explorations", "copied", "fresh")
    return {
        "instance": instance,
        "seed": 2**31 - 1,
        "generation": generation,
        **dict.fromkeys(names, -long),
        **dict.fromkeys(counts, 10**7),
        "accepted": False,
        "contribution": [long] * AGENTS,
    }


def summary() -> RunSummary:
    one = InstanceSummary(
        seed=2**31 - 1,
        generations=GENERATIONS_MADE,
        best_fitness=-1 / 3,
        fresh_mean=-1 / 3,
        fresh_sd=1 / 3,
        evaluations=10**9,
        env_steps=10**15,
    )
    return RunSummary(run_dir="", generations=GENERATIONS_MADE, instances=(one,) * INSTANCES)


@pytest.mark.slow
def test_a_finished_run_of_the_full_size_is_read(tmp_path):
    settings = full_size(tmp_path / "run")
    check_rows(settings)
    folder = RunFolder.create(settings, device="1 x cpu", kind="evolve", record={"search": "Search", "width": 64})
    assert len(row_line(row(499, 239))) < 0.8 * LONGEST_ROW
    with (folder.path / GENERATIONS).open("wb") as file:
        for generation in range(GENERATIONS_MADE):
            file.writelines(row_line(row(generation, instance)) for instance in range(INSTANCES))
    folder.write_timing(summary().timing())
    folder.write_summary(summary().to_json())
    write_sweep(tmp_path, [settings])
    run = read_run(tmp_path / "run")
    assert (len(run.rows), len(run.summary["instances"])) == (120_000, INSTANCES)
    assert ended(settings) is not None
    assert runs_below(tmp_path) == ([settings], 0)
    assert Watcher(tmp_path).done == 120_000
    RunFolder(folder.path, folder.config).sort_rows()
    RunFolder(folder.path, folder.config).cut_rows([GENERATIONS_MADE] * INSTANCES)


def test_a_solution_of_64_000_different_rules_is_read(tmp_path):
    """Whose figures do not compress."""
    grammar = load_grammar("both")
    mask, action = random_rules(grammar, AGENTS * RULES, CHANCE)
    figures = CHANCE.random((4, AGENTS, RULES), np.float32)
    rules = RuleSets(
        mask.reshape(AGENTS, RULES, -1),
        action.reshape(AGENTS, RULES),
        reflex=CHANCE.random((AGENTS, RULES)) < 0.5,
        quality=figures[3],
    )
    kind = CHANCE.integers(0, 3, (AGENTS, RULES), np.uint8)
    solution = SavedSolution(
        rules=rules,
        quality=figures[0],
        strength=figures[1],
        error=figures[2],
        usage=CHANCE.integers(0, 2**31 - 1, (AGENTS, RULES), np.int32),
        contribution=np.ones(AGENTS, np.float32),
        settings=full_size(rules=Rules(rules=RULES, grammar="both")),
        grammar_text=grammar.text,
        instance_seed=2**31 - 1,
        generation=10**7,
        fitness=0.5,
        deployments=6,
        origin_kind=kind,
        origin_generation=CHANCE.integers(0, 500, (AGENTS, RULES), np.int32),
        origin_agent=np.where(kind == 2, CHANCE.integers(0, AGENTS, (AGENTS, RULES)), -1).astype(np.int8),
    )
    solution.save(tmp_path / "x.npz")
    again = load_solution(tmp_path / "x.npz")
    np.testing.assert_array_equal(again.rules.mask, rules.mask)
    np.testing.assert_array_equal(again.rules.quality, rules.quality)
    np.testing.assert_array_equal(again.usage, solution.usage)
    np.testing.assert_array_equal(again.origin_agent, solution.origin_agent)


@pytest.mark.parametrize("instances", [1, INSTANCES])
def test_a_checkpoint_of_many_members_is_read(tmp_path, instances):
    """Of one instance all that it can hold, which cannot be compressed; of many a little."""
    generations = 12
    settings = full_size(tmp_path / "run", instances=instances, search=Search(generations=generations))
    folder = RunFolder.create(settings, device="1 x cpu", kind="evolve")
    members = generations + 1 if instances == 1 else 0
    own = {
        "search.members.data": np.frombuffer(CHANCE.bytes(members * 46 * AGENTS * RULES), np.uint8),
        "search.members.length": np.zeros((members, 2), np.int64),
        "search.pending.mask": np.zeros((1, AGENTS, RULES, 4) if instances == 1 else (0,), np.uint32),
    }
    count = settings.search.fresh_deployments if instances == 1 else 0
    figures = np.zeros((AGENTS, RULES), np.float32)
    one = Deployment(
        fitness=0.1,
        delivered=1,
        steps=1,
        contribution=np.zeros(AGENTS, np.int32),
        figures=Figures(quality=figures, strength=figures, error=figures, usage=figures.astype(np.int32)),
    )
    taken = pack_deployments(dict.fromkeys(range(count), one), (AGENTS, RULES))
    own |= {f"taken.{name}": array for name, array in taken.items()}
    arrays = {f"{instance}.{name}": array for instance in range(instances) for name, array in own.items()}
    about = {"instances": [{"search": {"rng": {"state": 2**127}, "word": "x" * 1500}}] * instances}
    folder.save_checkpoint(arrays, about)
    found, said = folder.load_checkpoint()
    assert set(found) == set(arrays)
    assert said == about
