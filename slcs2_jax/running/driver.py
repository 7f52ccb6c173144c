"""Whole runs: from settings to run folders. Runs that can share a device batch advance together."""

from __future__ import annotations

import contextlib
import math
import os
import shlex
import signal
import statistics
import time
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any

from slcs2_jax import runtime
from slcs2_jax.config import Jammers, Settings, World
from slcs2_jax.episode import physical
from slcs2_jax.grammar import GRAMMARS
from slcs2_jax.native.choice import computed_on, expected
from slcs2_jax.results import EvaluationSummary, Quiet, Report, RunSummary, ScenarioSummary
from slcs2_jax.results.loggers import check_logger
from slcs2_jax.results.reading import look
from slcs2_jax.results.summary import spread
from slcs2_jax.running.batches import make_batches, slots_per_device
from slcs2_jax.running.deployable import Deployable, bound
from slcs2_jax.running.evaluator import Evaluator
from slcs2_jax.running.memory import check_memory, check_rows, search_bytes
from slcs2_jax.running.run import Run, check_rules, prepare
from slcs2_jax.running.saving import Saver
from slcs2_jax.running.schedule import play
from slcs2_jax.running.stopping import Stopped, StopRequest
from slcs2_jax.running.task import Site
from slcs2_jax.search.evaluation import Deployment
from slcs2_jax.search.slcs2 import check_parts
from slcs2_jax.world.scenario import make_scenario


def evolve(
    settings: Sequence[Settings],
    *,
    report: Report | None = None,
    as_begun: bool = False,
) -> list[RunSummary]:
    """Evolve every run, writing its folder if ``run_dir`` is set (docs/model.md).

    Runs whose sizes and kind of world agree share one batch; where XLA computes, their physics must agree as well. What
    an instance comes to depends on its own settings and seed, not on its neighbours in the batch.

    A folder that holds the same run already is continued: a finished run is returned as it is, one that was interrupted
    goes on from where it was saved, one of fewer generations goes on from its end. Each comes to the same as if it had
    been made at once.

    Args:
        settings: one for each run.
        report: who is told of progress.
        as_begun: a run that goes on does so with the grammar it was begun with, even if the grammar's file is another
            one now; otherwise that is refused.

    Raises:
        InputError: a setting is impossible; a folder holds another run, a damaged one, or one that another process
            works on.
        StorageError: the disk refuses; what was saved before is intact.
        Stopped: SIGINT or SIGTERM came; everything is saved.
    """
    report = report or Quiet()
    for one in settings:
        check_parts(one.search)
        check_logger(one)
        check_rules(one)
    summaries, widths = _look(settings)
    runs: dict[int, Run] = {}
    with StopRequest() as stop, contextlib.ExitStack() as folders:
        batches = _batches(settings, widths)
        for place in widths:
            check_rows(settings[place])
        for width, places in batches:
            first = settings[places[0]]
            devices = runtime.devices(first.compute)
            host_bytes = sum(search_bytes(settings[place]) for place in widths)
            check_memory(first, host_bytes, width * len(devices), devices)
        for width, places in batches:
            for place in places:
                device = computed_on(settings[place].compute)
                run = prepare(settings[place], device=device, width=width, as_begun=as_begun, note=report.note)
                runs[place] = run
                folders.callback(run.close)
                if run.folder is not None and (changes := run.folder.config.changes(device)):
                    report.note(f"{run.folder.path}: {changes}, so the last bits of its results may be others")
                _raise_if_stopped(stop, runs.values())
        session = _Session([runs[place] for place in sorted(runs)], report, stop)
        for width, places in batches:
            session.advance([runs[place] for place in places], width)
    for place, run in runs.items():
        assert run.summary is not None
        summaries[place] = run.summary
    return [summaries[place] for place in range(len(settings))]


def _look(settings: Sequence[Settings]) -> tuple[dict[int, RunSummary], dict[int, int | None]]:
    """What the folders hold: summaries of runs that have ended, and of each other its slots per device if it began."""
    summaries: dict[int, RunSummary] = {}
    widths: dict[int, int | None] = {}
    for place, one in enumerate(settings):
        config, summary = (None, None) if one.run_dir is None else look(one)
        if summary is not None:
            summaries[place] = summary
        else:
            widths[place] = None if config is None else config.record["width"]
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

    def __init__(self, runs: Sequence[Run], report: Report, stop: StopRequest) -> None:
        self._instances = [instance for run in runs for instance in run.instances]
        self._runs, self._report, self._stop = runs, report, stop
        self._before = self._counts()

    def _counts(self) -> tuple[int, int]:
        instances = self._instances
        return sum(one.evaluations for one in instances), sum(one.env_steps for one in instances)

    def advance(self, runs: Sequence[Run], width: int) -> None:
        """Take a batch of runs to their end. Raises Stopped, StorageError, InputError."""
        instances = [instance for run in runs for instance in run.instances]
        start, steps = time.perf_counter(), sum(instance.useful_steps for instance in instances)
        saver = Saver(runs)

        def conclude() -> None:
            for run in runs:
                if run.summary is None and run.finished:
                    seconds = time.perf_counter() - start
                    made = sum(instance.useful_steps for instance in instances) - steps
                    run.conclude(seconds, made / seconds)

        def after_chunk() -> None:
            self._tell()
            conclude()
            saver.after_chunk()
            if self._stop.number is not None:
                saver.save_all()
                _raise_if_stopped(self._stop, self._runs)

        if not all(instance.finished for instance in instances):
            batches = make_batches(runs[0].settings, instances, width=width, note=self._report.note)
            usage = play(batches, after_chunk)
            for run in runs:
                run.note_usage(usage)
        conclude()

    def _tell(self) -> None:
        evaluations, env_steps = self._counts()
        told = [(one.search.generation, one) for one in self._instances]
        self._report.generation(
            done=[generation for generation, _ in told],
            best=[one.winner.fitness if generation else math.nan for generation, one in told],
            evaluations=evaluations - self._before[0],
            env_steps=env_steps - self._before[1],
        )


def _raise_if_stopped(stop: StopRequest, runs: Iterable[Run]) -> None:
    """Raise Stopped if a signal came; the message says how to go on."""
    if stop.number is None:
        return
    folders = [str(run.folder.path) for run in runs if run.folder is not None]
    name = signal.Signals(stop.number).name
    if not folders:
        raise Stopped(f"stopped by {name}; nothing is kept without run_dir", stop.number)
    folder = folders[0] if len(folders) == 1 else os.path.commonpath([os.path.abspath(one) for one in folders])
    raise Stopped(f"stopped by {name}, and all is saved; to go on: slcs2 resume {shlex.quote(folder)}", stop.number)


def evaluate(
    settings: Settings, policy: Deployable, *, deployments: int = 1, report: Report | None = None
) -> EvaluationSummary:
    """Deploy a policy in the scenarios of ``settings.instances`` seeds.

    Args:
        settings: of the swarm and its worlds.
        policy: rule-sets, a saved solution or a decision list; see ``bound``.
        deployments: in each scenario.
        report: who is told of progress.

    Raises:
        InputError: a setting is impossible, or does not fit the policy.
    """
    found = Evaluator(settings)([bound(policy, settings)], deployments=deployments, report=report)
    [rows] = found.deployments
    seconds = found.usage.seconds - found.usage.compile_seconds
    return EvaluationSummary(
        scenarios=tuple(
            _scenario_summary(settings.seed + instance, deployed) for instance, deployed in enumerate(rows)
        ),
        wall_seconds=seconds,
        env_steps_per_second=int(found.steps.sum()) / seconds,
    )


def deploy_in_runs(
    settings: Sequence[Settings], policy: Deployable, *, deployments: int, report: Report | None = None
) -> list[list[list[Deployment]]]:
    """Deploy a policy in every instance of every run; runs that can share a batch share it.

    Returns:
        For each of the settings, for each of its instances, the deployments in order.

    Raises:
        InputError: a setting is impossible, or does not fit the policy.
    """
    found: dict[int, list[list[Deployment]]] = {}
    alike: dict[Any, list[int]] = {}
    for place, one in enumerate(settings):
        alike.setdefault(batch_key(one), []).append(place)
    for places in alike.values():
        sites = {place: [_site(settings[place], seed) for seed in _seeds(settings[place])] for place in places}
        every = [site for place in places for site in sites[place]]
        [rows] = Evaluator(settings[places[0]]).at(every, [policy], deployments, report).deployments
        left = iter(rows)
        found |= {place: [list(next(left)) for _ in sites[place]] for place in places}
    return [found[place] for place in range(len(settings))]


def batch_key(settings: Settings) -> Any:
    """What runs must have in common to share a batch.

    Where the native chunk computes, physical values are each slot's own, and only sizes and parts count; XLA's programs
    take one value for all. Whatever decides which of the two computes is part of it, so that a run's neighbours decide
    nothing: users' grammars, worlds from files or of users' making, and jammers that are not the paper's.
    """
    world, grammar = settings.world, settings.rules.grammar
    usual = settings.jammers == Jammers() and world.file is None and world.scenario == World().scenario
    return (
        *(_sizes(settings) if expected(settings.compute) else (physical(settings),)),
        *(settings.task, settings.compute, settings.rules.rules, world.buildings),
        None if grammar in GRAMMARS else settings.rules,
        None if usual else (settings.jammers, world),
        settings.worlds,
        *(settings.knowledge.mode == "reflex", settings.search.inherit_quality),  # arrays that rule-sets have
    )


def _sizes(settings: Settings) -> tuple[Hashable, ...]:
    """What of the physics is no value of a slot: names of parts, sizes, whether agents fail and at how many times.

    Numbers that are no whole ones are values, and the number of packets.
    """
    sections = (settings.radio, settings.swarm, settings.learning)
    fixed = {name: value for one in sections for name, value in vars(one).items() if type(value) in (str, bool, int)}
    del fixed["packets"]
    times, fails = len(settings.swarm.failures_at), settings.swarm.failure_rate > 0
    return (*fixed.items(), settings.radio.channels, times, fails or times > 0)


def _site(settings: Settings, seed: int) -> Site:
    return Site.of(make_scenario(settings, seed), settings)


def _seeds(settings: Settings) -> range:
    return range(settings.seed, settings.seed + settings.instances)


def _scenario_summary(seed: int, deployed: Sequence[Deployment]) -> ScenarioSummary:
    fitness = [deployment.fitness for deployment in deployed]
    return ScenarioSummary(
        seed=seed,
        fitness=statistics.fmean(fitness),
        fitness_sd=spread(fitness),
        delivered=statistics.fmean(deployment.delivered for deployment in deployed),
        steps=statistics.fmean(deployment.steps for deployment in deployed),
        deployments=len(fitness),
    )
