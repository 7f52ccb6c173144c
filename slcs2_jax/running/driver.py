"""Whole runs: from settings to run folders. Runs that can share a device batch advance together."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import shlex
import signal
import statistics
import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from slcs2_jax import runtime
from slcs2_jax.config import Settings
from slcs2_jax.grammar import Grammar, RuleSets
from slcs2_jax.grammar.language import Sayer
from slcs2_jax.policy.decision_list import DecisionList
from slcs2_jax.policy.first_match import FirstMatch
from slcs2_jax.policy.policy import Policy
from slcs2_jax.results import EvaluationSummary, Quiet, Report, RunSummary, SavedSolution, ScenarioSummary
from slcs2_jax.results.reading import ended
from slcs2_jax.results.run_folder import check_usable
from slcs2_jax.results.summary import spread
from slcs2_jax.running.batches import make_batches, slots_per_device
from slcs2_jax.running.instance import Measurement, Site
from slcs2_jax.running.memory import check_memory, measurement_bytes, search_bytes
from slcs2_jax.running.run import MakeSearch, Run, prepare
from slcs2_jax.running.saving import Saver
from slcs2_jax.running.schedule import play
from slcs2_jax.running.stopping import Stopped, StopRequest
from slcs2_jax.search.slcs2 import Search
from slcs2_jax.swarm.task import task_of
from slcs2_jax.world.scenario import make_scenario


def evolve(
    settings: Sequence[Settings],
    *,
    report: Report | None = None,
    search: MakeSearch = Search,
    as_begun: bool = False,
) -> list[RunSummary]:
    """Evolve every run, writing its folder if ``run_dir`` is set (spec sections 7 and 8).

    Runs whose physics, sizes and kind of world agree share one batch. What an instance comes to depends on its own
    settings and seed, not on its neighbours in the batch.

    A folder that holds the same run already is gone on with: a finished run is returned as it is, one that was
    interrupted goes on from where it was saved, one of fewer generations goes on from its end. Each comes to the same
    as if it had been made at once.

    Args:
        settings: one for each run.
        report: who is told of progress.
        search: makes each instance's search, with the arguments of ``Search``; another kind may take its place.
        as_begun: a run that goes on does so with the grammar it was begun with, even if the grammar's file is another
            one now; otherwise that is refused.

    Raises:
        InputError: a setting is impossible; a folder holds another run, a damaged one, or one that another process
            works on.
        StorageError: the disk refuses; what was saved before is intact.
        Stopped: SIGINT or SIGTERM came; everything is saved.
    """
    report = report or Quiet()
    summaries, widths = _found(settings)
    members: dict[int, Run] = {}
    with StopRequest() as stop, contextlib.ExitStack() as folders:
        batches = _batches(settings, widths)
        for width, places in batches:
            first = settings[places[0]]
            devices = runtime.devices(first.compute)
            host_bytes = sum(search_bytes(settings[place]) for place in widths)
            check_memory(first, host_bytes, width * len(devices), devices)
        for width, places in batches:
            for place in places:
                device = runtime.describe_devices(settings[place].compute)
                member = prepare(settings[place], search, device=device, width=width, as_begun=as_begun)
                members[place] = member
                folders.callback(member.close)
                if member.folder is not None and (changes := member.folder.config.changes(device)):
                    report.note(f"{member.folder.path}: {changes}, so the last bits of its results may be others")
                _raise_if_stopped(stop, members.values())
        session = _Session([members[place] for place in sorted(members)], report, stop)
        for width, places in batches:
            session.advance([members[place] for place in places], width)
    for place, member in members.items():
        assert member.summary is not None
        summaries[place] = member.summary
    return [summaries[place] for place in range(len(settings))]


def _found(settings: Sequence[Settings]) -> tuple[dict[int, RunSummary], dict[int, int | None]]:
    """What the folders hold: summaries of runs that have ended, and of each other its slots per device if it began."""
    summaries: dict[int, RunSummary] = {}
    widths: dict[int, int | None] = {}
    for place, one in enumerate(settings):
        summary = ended(one)
        if summary is not None:
            summaries[place] = summary
        else:
            found = None if one.run_dir is None else check_usable(one)
            widths[place] = None if found is None else found.record["width"]
    return summaries, widths


def _batches(settings: Sequence[Settings], widths: Mapping[int, int | None]) -> list[tuple[int, list[int]]]:
    """Which runs advance together, and with how many slots per device.

    The number of slots decides the last bits of the arithmetic, so a run that goes on keeps what it began with; one
    that begins joins those that it can.
    """
    alike: dict[Any, list[int]] = {}
    for place in widths:
        alike.setdefault(batch_key(settings[place]), []).append(place)
    batches: list[tuple[int, list[int]]] = []
    for places in alike.values():
        first = settings[places[0]]
        known = [width for place in places if (width := widths[place]) is not None]
        new = known[0] if known else slots_per_device(first, sum(settings[place].instances for place in places))
        by_width: dict[int, list[int]] = {}
        for place in places:
            by_width.setdefault(widths[place] or new, []).append(place)
        batches += by_width.items()
    return batches


class _Session:
    """Advances batches of runs one after the other, tells of all of them, and saves."""

    def __init__(self, members: Sequence[Run], report: Report, stop: StopRequest) -> None:
        self._runs = [run for member in members for run in member.runs]
        self._members, self._report, self._stop = members, report, stop
        self._before = self._counts()

    def _counts(self) -> tuple[int, int]:
        return sum(run.evaluations for run in self._runs), sum(run.env_steps for run in self._runs)

    def advance(self, members: Sequence[Run], width: int) -> None:
        """Run a batch to its end. Raises Stopped, StorageError, InputError."""
        runs = [run for member in members for run in member.runs]
        start, steps = time.perf_counter(), sum(run.useful_steps for run in runs)
        saver = Saver(members)

        def conclude() -> None:
            for member in members:
                if member.summary is None and member.finished:
                    seconds = time.perf_counter() - start
                    made = sum(run.useful_steps for run in runs) - steps
                    member.conclude(seconds, made / seconds)

        def after_chunk() -> None:
            self._tell()
            conclude()
            saver.after_chunk()
            if self._stop.number is not None:
                saver.save_all()
                _raise_if_stopped(self._stop, self._members)

        if not all(run.finished for run in runs):
            grammars = [member.grammar for member in members]
            batches = make_batches(members[0].settings, grammars, runs, width=width, note=self._report.note)
            usage = play(batches, after_chunk)
            for member in members:
                member.note_usage(usage)
        conclude()

    def _tell(self) -> None:
        evaluations, env_steps = self._counts()
        self._report.generation(
            done=[run.search.generation for run in self._runs],
            best=[run.winner.fitness if run.search.generation else math.nan for run in self._runs],
            evaluations=evaluations - self._before[0],
            env_steps=env_steps - self._before[1],
        )


def _raise_if_stopped(stop: StopRequest, members: Iterable[Run]) -> None:
    """Raise Stopped if a signal came; the message says how to go on."""
    if stop.number is None:
        return
    folders = [str(member.folder.path) for member in members if member.folder is not None]
    name = signal.Signals(stop.number).name
    if not folders:
        raise Stopped(f"stopped by {name}; nothing is kept without run_dir", stop.number)
    folder = folders[0] if len(folders) == 1 else os.path.commonpath([os.path.abspath(one) for one in folders])
    raise Stopped(f"stopped by {name}, and all is saved; to go on: slcs2 resume {shlex.quote(folder)}", stop.number)


def evaluate(
    settings: Settings, solution: SavedSolution, *, deployments: int = 1, report: Report | None = None
) -> EvaluationSummary:
    """Deploy a saved solution in the scenarios of ``settings.instances`` seeds.

    Raises:
        InputError: a setting is impossible, or does not fit the solution.
    """
    solution.check_fits(settings)
    grammar = Grammar.of(settings, solution.grammar_text)
    return _measure(settings, solution.rules, grammar, None, deployments, report or Quiet())


def evaluate_list(
    settings: Settings, decisions: DecisionList, *, deployments: int = 1, report: Report | None = None
) -> EvaluationSummary:
    """Deploy a decision list in the scenarios of ``settings.instances`` seeds; ``settings.rules`` is unused.

    Raises:
        InputError: a setting is impossible.
    """
    settings = dataclasses.replace(settings, rules=dataclasses.replace(settings.rules, rules=len(decisions.rules)))
    rules = decisions.rule_sets(settings.swarm.agents)
    return _measure(settings, rules, decisions, FirstMatch(), deployments, report or Quiet())


def _measure(
    settings: Settings, rules: RuleSets, said: Sayer, policy: Policy | None, deployments: int, report: Report
) -> EvaluationSummary:
    devices = runtime.devices(settings.compute)
    width = slots_per_device(settings, settings.instances * deployments)
    check_memory(settings, measurement_bytes(settings, deployments), width * len(devices), devices)
    sites = [_site(settings, said, instance) for instance in range(settings.instances)]
    tasks = [Measurement(site, rules, deployments) for site in sites]
    batches = make_batches(settings, [said], tasks, width=width, policy=policy, note=report.note)
    start = time.perf_counter()

    def tell() -> None:
        found = [[one.fitness for one in task.deployments] for task in tasks]
        report.generation(
            done=[len(task.taken) for task in tasks],
            best=[max(values, default=math.nan) for values in found],
            evaluations=sum(map(len, found)),
            env_steps=sum(one.steps for task in tasks for one in task.deployments),
        )

    play(batches, tell)
    seconds = time.perf_counter() - start
    steps = sum(one.steps for task in tasks for one in task.deployments)
    return EvaluationSummary(
        scenarios=tuple(_scenario_summary(task) for task in tasks),
        wall_seconds=seconds,
        env_steps_per_second=steps / seconds,
    )


def batch_key(settings: Settings) -> Any:
    """What runs must have in common to share a batch."""
    world = settings.world
    sizes = (settings.rules.rules, world.wall_thickness, world.buildings)
    return settings.radio, settings.swarm, settings.learning, settings.task, settings.compute, sizes


def _site(settings: Settings, said: Sayer, instance: int) -> Site:
    scenario = make_scenario(settings, settings.seed + instance)
    return Site(scenario, said.channels_used, settings.swarm.packets, task_of(settings))


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
