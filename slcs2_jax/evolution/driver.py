"""Whole runs: from settings to run folders. Runs that can share a device batch advance together."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from slcs2_jax import runtime
from slcs2_jax.config import Settings
from slcs2_jax.episode import Parameters
from slcs2_jax.evolution.member import Member
from slcs2_jax.evolution.schedule import play
from slcs2_jax.evolution.search import HistoryRow, Search
from slcs2_jax.evolution.tasks import Measurement, Run, Site
from slcs2_jax.grammar import Grammar, RuleSets, load_grammar, parse_grammar, random_rules
from slcs2_jax.results import (
    EvaluationSummary,
    InstanceSummary,
    Quiet,
    Report,
    RunFolder,
    RunSummary,
    SavedSolution,
    ScenarioSummary,
)
from slcs2_jax.results.summary import spread
from slcs2_jax.rollout import LANES, Rollout, Shape
from slcs2_jax.world.arena import wall_capacity
from slcs2_jax.world.scenario import make_scenario


@dataclass(eq=False)
class Instances:
    """One run's settings, its instances and its folder, if it has one."""

    settings: Settings
    grammar: Grammar
    folder: RunFolder | None
    runs: list[Run]


def evolve(
    settings: Sequence[Settings], *, report: Report | None = None, search: Callable[..., Search] = Search
) -> list[RunSummary]:
    """Evolve every run, writing its folder if ``run_dir`` is set (spec sections 7 and 8).

    Runs whose physics, sizes and kind of world agree share one batch. What an instance comes to depends on its own
    settings and seed, not on its neighbours in the batch.

    Args:
        settings: one for each run.
        report: who is told of progress.
        search: makes each instance's search, with the arguments of ``Search``; another kind may take its place.

    Raises:
        InputError: a setting is impossible, or a folder holds another run.
    """
    report = report or Quiet()
    groups: dict[Any, list[int]] = {}
    for place, one in enumerate(settings):
        groups.setdefault(_batch_key(one), []).append(place)
    everything = [_prepare(one, search) for one in settings]
    summaries: dict[int, RunSummary] = {}
    for places in groups.values():
        members = [everything[place] for place in places]
        seconds = _advance(members, everything, report)
        steps = sum(run.all_steps for member in members for run in member.runs)
        for place, member in zip(places, members, strict=True):
            summaries[place] = _conclude(member, seconds, steps / seconds)
    return [summaries[place] for place in range(len(settings))]


def evaluate(
    settings: Settings, solution: SavedSolution, *, deployments: int = 1, report: Report | None = None
) -> EvaluationSummary:
    """Deploy a saved solution in the scenarios of ``settings.instances`` seeds.

    Raises:
        InputError: a setting is impossible.
    """
    report = report or Quiet()
    rules = settings.rules
    grammar = parse_grammar(
        solution.grammar_text,
        name=rules.grammar,
        max_clauses=rules.max_clauses,
        single_option_consumes=rules.single_option_consumes,
    )
    sites = [_site(settings, grammar, instance) for instance in range(settings.instances)]
    tasks = [Measurement(site, solution.rules, deployments) for site in sites]
    rollout = make_rollout(settings, [grammar], sites, len(tasks) * deployments)
    start = time.perf_counter()

    def tell() -> None:
        found = [[one.fitness for one in task.deployments] for task in tasks]
        report.generation(
            done=[len(task.taken) for task in tasks],
            best=[max(values, default=math.nan) for values in found],
            evaluations=sum(map(len, found)),
            env_steps=sum(one.steps for task in tasks for one in task.deployments),
        )

    play(tasks, rollout, tell)
    seconds = time.perf_counter() - start
    steps = sum(one.steps for task in tasks for one in task.deployments)
    return EvaluationSummary(
        scenarios=tuple(_scenario_summary(task) for task in tasks),
        wall_seconds=seconds,
        env_steps_per_second=steps / seconds,
    )


def _batch_key(settings: Settings) -> Any:
    """What runs must have in common to share a batch."""
    world = settings.world
    sizes = (settings.rules.rules, world.wall_thickness, world.buildings)
    return settings.radio, settings.swarm, settings.learning, settings.compute, sizes


def _prepare(settings: Settings, make_search: Callable[..., Search]) -> Instances:
    rules = settings.rules
    grammar = load_grammar(
        rules.grammar, max_clauses=rules.max_clauses, single_option_consumes=rules.single_option_consumes
    )
    sites = [_site(settings, grammar, instance) for instance in range(settings.instances)]
    folder = None
    if settings.run_dir is not None:
        folder = RunFolder.create(settings, device=runtime.describe_devices(settings.compute))
    runs = []
    for instance, site in enumerate(sites):
        search = make_search(
            settings.search,
            agents=settings.swarm.agents,
            rules=rules.rules,
            seed=site.scenario.seed,
            source=partial(_draw_rules, grammar, rules.codons),
        )
        record = partial(_record, folder, instance, site.scenario.seed)
        runs.append(Run(search, site, settings.search.fresh_deployments, record))
    return Instances(settings, grammar, folder, runs)


def _draw_rules(grammar: Grammar, codons: int, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return random_rules(grammar, count, rng, codons=codons)


def _record(folder: RunFolder | None, instance: int, seed: int, row: HistoryRow) -> None:
    if folder is None:
        return
    values = asdict(row)
    if math.isnan(row.novelty):  # the first solution has nobody to differ from
        values["novelty"] = None
    folder.append([{"instance": instance, "seed": seed, **values}])


def _site(settings: Settings, grammar: Grammar, instance: int) -> Site:
    scenario = make_scenario(settings, settings.seed + instance)
    return Site(scenario, grammar.channels_used, settings.swarm.packets)


def make_rollout(settings: Settings, grammars: Sequence[Grammar], sites: Sequence[Site], tasks: int) -> Rollout:
    """Slots for so many tasks on the given sites, as ``settings.compute`` says or as the devices like it."""
    shape = Shape(
        agents=settings.swarm.agents,
        rules=settings.rules.rules,
        words=max(grammar.words for grammar in grammars),
        channels=1 + max(max(grammar.channels_used) for grammar in grammars),
        walls=wall_capacity([site.scenario for site in sites]),
    )
    devices = runtime.devices(settings.compute)
    slots = settings.compute.slots or _enough_slots(devices, tasks)
    return Rollout(Parameters.of(settings), shape, slots=slots, devices=devices, chunk=settings.compute.chunk)


def _enough_slots(devices: Sequence[Any], tasks: int) -> int:
    """CPUs are fastest with one vector's width each; a GPU takes twice what is certain to be wanted."""
    return LANES * len(devices) if devices[0].platform == "cpu" else 2 * tasks


def _advance(members: Sequence[Instances], everything: Sequence[Instances], report: Report) -> float:
    """Run a group to its end; returns the seconds it took."""
    runs = [run for member in members for run in member.runs]
    shown = [run for member in everything for run in member.runs]
    start = time.perf_counter()
    grammars = [member.grammar for member in members]
    rollout = make_rollout(members[0].settings, grammars, [run.site for run in runs], len(runs))

    def tell() -> None:
        report.generation(
            done=[run.search.generation for run in shown],
            best=[run.winner.fitness if run.search.generation else math.nan for run in shown],
            evaluations=sum(run.evaluations for run in shown),
            env_steps=sum(run.env_steps for run in shown),
        )

    play(runs, rollout, tell)
    return time.perf_counter() - start


def _conclude(member: Instances, seconds: float, rate: float) -> RunSummary:
    """Save the solutions and sum up; seconds and rate are those of all runs that shared the batch."""
    for instance, run in enumerate(member.runs):
        if member.folder is not None:
            member.folder.save_best(instance, _saved(member, run, run.winner))
            for place, one in enumerate(run.search.members):
                member.folder.save_member(instance, place, _saved(member, run, one))
    instances = tuple(_instance_summary(run) for run in member.runs)
    summary = RunSummary(
        run_dir="" if member.folder is None else str(member.folder.path),
        instances=instances,
        wall_seconds=seconds,
        env_steps_per_second=rate,
    )
    if member.folder is not None:
        member.folder.write_summary(summary.to_json())
    return summary


def _saved(member: Instances, run: Run, one: Member) -> SavedSolution:
    evaluation = one.evaluation
    return SavedSolution(
        rules=RuleSets(one.solution.mask, one.solution.action),
        quality=evaluation.quality,
        strength=evaluation.strength,
        error=evaluation.error,
        usage=np.rint(evaluation.usage).astype(np.int32),
        contribution=evaluation.contribution.astype(np.float32),
        settings=member.settings,
        grammar_text=member.grammar.text,
        instance_seed=run.site.scenario.seed,
        generation=one.generation,
        fitness=one.fitness,
        deployments=evaluation.deployments,
    )


def _instance_summary(run: Run) -> InstanceSummary:
    assert run.measurement is not None
    fresh = [one.fitness for one in run.measurement.deployments]
    return InstanceSummary(
        seed=run.site.scenario.seed,
        best_fitness=run.winner.fitness,
        fresh_mean=statistics.fmean(fresh),
        fresh_sd=spread(fresh),
        evaluations=run.evaluations,
        env_steps=run.env_steps,
    )


def _scenario_summary(task: Measurement) -> ScenarioSummary:
    fitness = [one.fitness for one in task.deployments]
    return ScenarioSummary(
        seed=task.site.scenario.seed,
        fitness=statistics.fmean(fitness),
        fitness_sd=spread(fitness),
        delivered=statistics.fmean(one.delivered for one in task.deployments),
        steps=statistics.fmean(one.steps for one in task.deployments),
        deployments=len(fitness),
    )
