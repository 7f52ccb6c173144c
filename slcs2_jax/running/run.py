"""One run: its settings, its instances and its folder; how it starts or goes on, is saved, and ends."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.door import telling_damage
from slcs2_jax.grammar import Grammar, random_rules
from slcs2_jax.looking.solutions import as_saved
from slcs2_jax.results import InstanceSummary, RunFolder, RunSummary, SavedSolution
from slcs2_jax.results.reading import read_timing
from slcs2_jax.results.summary import spread
from slcs2_jax.running.instance import Instance, Site
from slcs2_jax.running.usage import Usage
from slcs2_jax.search.member import Member
from slcs2_jax.search.slcs2 import HistoryRow, Search
from slcs2_jax.swarm.task import task_of
from slcs2_jax.world.scenario import make_scenario

MakeSearch = Callable[..., Search]


@dataclass(eq=False)
class Run:
    """One run that is advanced."""

    settings: Settings
    grammar: Grammar
    folder: RunFolder | None
    runs: list[Instance]
    seconds_before: float = 0.0  # of former sessions
    summary: RunSummary | None = None  # once it has ended

    @property
    def finished(self) -> bool:
        """Whether every instance has ended."""
        return all(run.finished for run in self.runs)

    @property
    def progress(self) -> list[tuple[int, int]]:
        """What was done, by instance; see `Instance.progress`."""
        return [run.progress for run in self.runs]

    def save(self, seconds: float) -> None:
        """Replace the checkpoint; seconds are those of this session."""
        assert self.folder is not None
        arrays: dict[str, np.ndarray] = {}
        about: dict[str, Any] = {"generations": self.settings.search.generations, "instances": []}
        for instance, run in enumerate(self.runs):
            own, meta = run.state()
            arrays |= {f"{instance}.{name}": array for name, array in own.items()}
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
        self.folder.cut_rows([run.search.generation for run in self.runs])

    def _restore(self, arrays: dict[str, np.ndarray], about: dict[str, Any]) -> None:
        if len(about["instances"]) != len(self.runs):
            raise InputError(f"{len(about['instances'])} instances; accepted are {len(self.runs)}")
        if about["generations"] > self.settings.search.generations:
            raise InputError(f"it is that of a run of {about['generations']} generations")
        parts: list[dict[str, np.ndarray]] = [{} for _ in self.runs]
        for name, array in arrays.items():
            instance, _, rest = name.partition(".")
            parts[int(instance)][rest] = array
        for run, own, meta in zip(self.runs, parts, about["instances"], strict=True):
            run.restore(own, meta)

    def conclude(self, seconds: float, rate: float) -> None:
        """Save the solutions and sum up; seconds and rate are those of all runs that share the batch."""
        self.summary = RunSummary(
            run_dir="" if self.folder is None else str(self.folder.path),
            generations=self.settings.search.generations,
            instances=tuple(map(_instance_summary, self.runs)),
            wall_seconds=self.seconds_before + seconds,
            env_steps_per_second=rate,
        )
        if self.folder is None:
            return
        kept = []
        for instance, run in enumerate(self.runs):
            kept.append(self.folder.save_best(instance, self._saved(run, run.winner)))
            for place, one in enumerate(run.search.members):
                kept.append(self.folder.save_member(instance, place, self._saved(run, one)))
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
        """Let go of the folder."""
        if self.folder is not None:
            self.folder.close()

    def _saved(self, run: Instance, one: Member) -> SavedSolution:
        return as_saved(one, self.settings, self.grammar.text, run.site.scenario.seed)


def prepare(settings: Settings, make_search: MakeSearch, *, device: str, width: int, as_begun: bool = False) -> Run:
    """The run of these settings, from its start or from where its folder stands; the folder stays locked.

    Args:
        settings: of the run.
        make_search: makes each instance's search, with the arguments of `Search`.
        device: what it is computed on, in words.
        width: slots per device of its batch.
        as_begun: go on with the grammar that the run was begun with, even if its file is another one now.

    Raises:
        InputError: the folder holds another run, a damaged one, or one that another process works on.
        StorageError: the disk refuses.
    """

    def load() -> Grammar:
        return Grammar.of(settings)

    if settings.run_dir is None:
        grammar = load()
        return Run(settings, grammar, None, _runs(settings, grammar, None, make_search))
    record = {"width": width, "search": search_name(make_search)}
    folder = RunFolder.open(settings, device=device, grammar_text=lambda: load().text, record=record)
    try:
        _check_search(folder, make_search)
        started = folder.read_grammar()
        if not as_begun:
            _check_grammar(folder, started, load)
        grammar = Grammar.of(settings, started)
        one = Run(settings, grammar, folder, _runs(settings, grammar, folder, make_search))
        one.restore()
    except BaseException:
        folder.close()
        raise
    return one


def _check_grammar(folder: RunFolder, started: str, load: Callable[[], Grammar]) -> None:
    """Refuse to go on with another text than the run was started with. If the file is gone, the folder has it."""
    try:
        now = load()
    except InputError:
        return
    if now.text != started:
        raise InputError(
            f"grammar={now.name}: is not what it was when the run in {folder.path} was started; accepted is "
            f"the text of {folder.path / 'grammar.bnf'}, or another run_dir"
        )


def search_name(make_search: MakeSearch) -> str:
    """What a folder says of the search that made it."""
    made: Any = getattr(make_search, "func", make_search)  # look into a functools.partial
    return getattr(made, "__qualname__", type(made).__name__)


def _check_search(folder: RunFolder, make_search: MakeSearch) -> None:
    found, name = folder.config.record.get("search"), search_name(make_search)
    if found != name:
        raise InputError(f"run_dir={folder.path}: its run was made by the search {found}; accepted is that, not {name}")


def _runs(settings: Settings, grammar: Grammar, folder: RunFolder | None, make_search: MakeSearch) -> list[Instance]:
    runs = []
    for instance in range(settings.instances):
        scenario = make_scenario(settings, settings.seed + instance)
        search = make_search(
            settings.search,
            agents=settings.swarm.agents,
            rules=settings.rules.rules,
            seed=scenario.seed,
            source=partial(_draw_rules, grammar, settings.rules.codons),
        )
        site = Site(scenario, grammar.channels_used, settings.swarm.packets, task_of(settings))
        record = partial(_record, folder, instance, scenario.seed)
        runs.append(Instance(search, site, settings.search.fresh_deployments, record))
    return runs


def _draw_rules(grammar: Grammar, codons: int, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return random_rules(grammar, count, rng, codons=codons)


def _record(folder: RunFolder | None, instance: int, seed: int, row: HistoryRow) -> None:
    if folder is None:
        return
    values = asdict(row)
    if math.isnan(row.novelty):  # the first solution has nobody to differ from
        values["novelty"] = None
    folder.append([{"instance": instance, "seed": seed, **values}])


def _instance_summary(run: Instance) -> InstanceSummary:
    assert run.measurement is not None
    fresh = [one.fitness for one in run.measurement.deployments]
    return InstanceSummary(
        seed=run.site.scenario.seed,
        generations=run.search.generation,
        best_fitness=run.winner.fitness,
        fresh_mean=statistics.fmean(fresh),
        fresh_sd=spread(fresh),
        evaluations=run.evaluations,
        env_steps=run.env_steps,
    )
