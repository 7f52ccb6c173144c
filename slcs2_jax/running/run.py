"""One run: its settings, its instances and its folder; how it starts or goes on, is saved, and ends."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.door import telling_damage
from slcs2_jax.config.registry import KINDS
from slcs2_jax.config.worlds import worlds_of
from slcs2_jax.grammar import Grammar, random_rules
from slcs2_jax.grammar.live import Bounds, live_rules
from slcs2_jax.results import InstanceSummary, RunFolder, RunSummary, SavedSolution
from slcs2_jax.results.loggers import Told
from slcs2_jax.results.progress import counted
from slcs2_jax.results.reading import look, read_timing
from slcs2_jax.results.run_folder import GRAMMAR, KNOWLEDGE
from slcs2_jax.results.summary import spread
from slcs2_jax.running.deployable import of_grammar
from slcs2_jax.running.instance import Instance
from slcs2_jax.running.solutions import as_saved
from slcs2_jax.running.task import Site
from slcs2_jax.running.usage import Usage
from slcs2_jax.search.history import HistoryRow
from slcs2_jax.search.knowledge import Knowledge
from slcs2_jax.search.member import Member
from slcs2_jax.search.packing import part_of
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.protocol import MakeSearch
from slcs2_jax.world.scenario import make_scenario


@dataclass(eq=False)
class Run:
    """One run that is advanced."""

    settings: Settings
    grammar: Grammar
    folder: RunFolder | None
    instances: list[Instance]
    log: Told
    seconds_before: float = 0.0  # of former sessions
    summary: RunSummary | None = None  # once it has ended

    @property
    def finished(self) -> bool:
        """Whether every instance has ended."""
        return all(instance.finished for instance in self.instances)

    @property
    def progress(self) -> list[tuple[int, int]]:
        """What was done, by instance; see `Instance.progress`."""
        return [instance.progress for instance in self.instances]

    def save(self, seconds: float) -> None:
        """Replace the checkpoint; seconds are those of this session."""
        assert self.folder is not None
        arrays: dict[str, np.ndarray] = {}
        about: dict[str, Any] = {"generations": self.settings.search.generations, "instances": []}
        for number, instance in enumerate(self.instances):
            parts, meta = instance.state()
            arrays |= {f"{number}.{name}": array for name, array in parts.items()}
            about["instances"].append(meta)
        self.folder.save_checkpoint(arrays, about)
        self.folder.write_timing({"wall_seconds": self.seconds_before + seconds})

    def restore(self) -> None:
        """Go on from the folder's checkpoint, if it has one: rows beyond it are cut, and will come again.

        Raises InputError naming the file that is damaged or missing.
        """
        assert self.folder is not None
        stored = self.folder.load_checkpoint()
        if stored is not None:
            arrays, about = stored
            try:
                with telling_damage():  # put together by something else than this program
                    self._restore(arrays, about)
            except InputError as error:
                raise self.folder.bad_checkpoint(error) from None
        self.seconds_before = float((read_timing(self.folder.path) or {}).get("wall_seconds", 0.0))
        self.folder.cut_rows([instance.search.generation for instance in self.instances])

    def _restore(self, arrays: dict[str, np.ndarray], about: dict[str, Any]) -> None:
        if len(about["instances"]) != len(self.instances):
            raise InputError(f"{len(about['instances'])} instances; accepted are {len(self.instances)}")
        if about["generations"] > self.settings.search.generations:
            raise InputError(f"it is that of a run of {about['generations']} generations")
        for number, (instance, meta) in enumerate(zip(self.instances, about["instances"], strict=True)):
            instance.restore(part_of(arrays, str(number)), meta)

    def conclude(self, seconds: float, rate: float) -> None:
        """Save the solutions and sum up; seconds and rate are those of all runs that share the batch."""
        self.summary = RunSummary(
            run_dir="" if self.folder is None else str(self.folder.path),
            generations=self.settings.search.generations,
            instances=tuple(map(_instance_summary, self.instances)),
            wall_seconds=self.seconds_before + seconds,
            env_steps_per_second=rate,
        )
        self.log.summary(self.summary.to_json())
        if self.folder is None:
            return
        kept = []
        for number, instance in enumerate(self.instances):
            kept.append(self.folder.save_best(number, self._saved(instance, instance.winner)))
            for place, member in enumerate(instance.search.members):
                kept.append(self.folder.save_member(number, place, self._saved(instance, member)))
        self.folder.keep_solutions(kept)
        self.folder.sort_rows()
        self.save(seconds)
        self.folder.write_timing(self.summary.timing())
        self.folder.write_summary(self.summary.to_json())

    def note_usage(self, usage: Usage) -> None:
        """Add to the summary where the time of the session went."""
        assert self.summary is not None
        self.summary = replace(
            self.summary,
            compile_seconds=usage.compile_seconds,
            host_share=usage.host_share,
            useful_share=usage.useful_share,
        )
        if self.folder is not None:
            self.folder.write_timing(self.summary.timing())

    def close(self) -> None:
        """Let go of the folder, and of who is told."""
        self.log.close()
        if self.folder is not None:
            self.folder.close()

    def _saved(self, instance: Instance, member: Member) -> SavedSolution:
        return as_saved(member, self.settings, self.grammar.text, instance.site.seed)


def prepare(
    settings: Settings,
    *,
    device: str,
    width: int,
    as_begun: bool = False,
    note: Callable[[str], None] = lambda text: None,
) -> Run:
    """The run of these settings, from its start or from where its folder stands; the folder stays locked.

    Args:
        settings: of the run.
        device: what it is computed on, in words.
        width: slots per device of its batch.
        as_begun: go on with the grammar and knowledge that the run was begun with, even if the files are others now.
        note: told if its logger fails.

    Raises:
        InputError: there is no such search; or the folder holds another run, a damaged one, or one that another process
            works on.
        StorageError: the disk refuses.
    """
    make = KINDS["search"].get(settings.search.name)
    if settings.run_dir is None:
        grammar = Grammar.of(settings)
        log = Told(settings, note)
        log.start()
        return Run(settings, grammar, None, _instances(settings, grammar, None, log, make), log)
    folder = RunFolder.open(settings, device=device, texts=partial(_texts, settings), record={"width": width})
    try:
        started = {GRAMMAR: folder.read_grammar()}
        if (known := folder.read_knowledge()) is not None:
            started[KNOWLEDGE] = known
        if not as_begun:
            _check_texts(folder, started, settings)
        grammar = Grammar.of(settings, started[GRAMMAR])
        log = Told(settings, note)
        run = Run(settings, grammar, folder, _instances(settings, grammar, folder, log, make, known), log)
        run.restore()
        log.start()
    except BaseException:
        folder.close()
        raise
    return run


def check_rules(settings: Settings) -> None:
    """Refuse knowledge that cannot be used and a grammar of too few rules, before anything is made of the run.

    Raises InputError.
    """
    rules = settings.rules
    if settings.knowledge.mode == "none" and not rules.distinct:
        return
    if settings.run_dir is not None and look(settings)[0] is not None:
        return
    grammar = Grammar.of(settings)
    knowledge = Knowledge.of(settings, grammar)
    if rules.distinct:
        problem = _problem(settings, grammar, knowledge, settings.seed)
        problem.random_solution(problem.supply(), 0)


def _texts(settings: Settings) -> dict[str, str]:
    """What the folder of a run keeps, by its name there: the grammar, and the list of knowledge if there is one."""
    grammar = Grammar.of(settings)
    knowledge = Knowledge.of(settings, grammar)
    return {GRAMMAR: grammar.text} | ({} if knowledge is None else {KNOWLEDGE: knowledge.text})


def _check_texts(folder: RunFolder, started: Mapping[str, str], settings: Settings) -> None:
    """Refuse to go on with other texts than the run was started with. Of files that are gone, the folder has them."""
    try:
        now = _texts(settings)
    except InputError:
        return
    said = {GRAMMAR: f"grammar={settings.rules.grammar}", KNOWLEDGE: f"knowledge.rules={settings.knowledge.rules}"}
    for name, text in now.items():
        if text != started[name]:
            raise InputError(
                f"{said[name]}: is not what it was when the run in {folder.path} was started; accepted is "
                f"the text of {folder.path / name}, or another run_dir"
            )


def _instances(
    settings: Settings,
    grammar: Grammar,
    folder: RunFolder | None,
    log: Told,
    make: MakeSearch,
    known: str | None = None,
) -> list[Instance]:
    """`known`: the list of knowledge that the run was begun with."""
    instances = []
    knowledge = Knowledge.of(settings, grammar, known)
    shared = [make_scenario(its, seed) for _, its, seed in counted(worlds_of(settings), "worlds made:")]
    for number in counted(range(settings.instances), "worlds made:"):
        seed = settings.seed + number
        scenarios = shared or [make_scenario(settings, seed)]
        problem = _problem(settings, grammar, knowledge, seed)
        site = replace(Site.of(scenarios[0], settings), scenarios=tuple(scenarios), seed=seed)
        record = partial(_record, folder, log, number, seed)
        instances.append(Instance(make(problem), problem, site, partial(of_grammar, grammar), record))
    return instances


def _problem(settings: Settings, grammar: Grammar, knowledge: Knowledge | None, seed: int) -> Problem:
    bounds = Bounds.of(settings) if settings.rules.distinct else None
    return Problem(
        settings=settings.search,
        agents=settings.swarm.agents,
        rules=settings.rules.rules,
        seed=seed,
        source=partial(_draw_rules, grammar, settings.rules.codons, bounds),
        vocabulary=grammar.vocabulary,
        knowledge=knowledge,
        initial_quality=settings.learning.initial_quality,
        distinct=settings.rules.distinct,
        worlds=max(1, len(worlds_of(settings))),
        kinds=max(1, len(settings.worlds)),
    )


def _draw_rules(
    grammar: Grammar, codons: int, bounds: Bounds | None, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    if bounds is None:
        return random_rules(grammar, count, rng, codons=codons)
    return live_rules(grammar, count, rng, codons=codons, bounds=bounds)


def _record(folder: RunFolder | None, log: Told, number: int, seed: int, row: HistoryRow) -> None:
    values = asdict(row)
    if math.isnan(row.novelty):  # the first solution has nobody to differ from
        values["novelty"] = None
    told = {"instance": number, "seed": seed, **values}
    if folder is not None:
        folder.append([told])
    log.generation(told)


def _instance_summary(instance: Instance) -> InstanceSummary:
    assert instance.measurement is not None
    measured = instance.measurement.deployments
    fresh = [deployment.fitness for deployment in measured]
    return InstanceSummary(
        seed=instance.site.seed,
        generations=instance.search.generation,
        best_fitness=instance.winner.fitness,
        fresh_mean=statistics.fmean(fresh),
        fresh_sd=spread(fresh),
        evaluations=instance.evaluations,
        env_steps=instance.env_steps,
        fresh_failed=statistics.fmean(deployment.delivered == 0 for deployment in measured),
    )
