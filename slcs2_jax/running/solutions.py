"""Solutions that a run has made: as they are saved, and as its last checkpoint holds them."""

from __future__ import annotations

import dataclasses
import struct
import zlib

import numpy as np

from slcs2_jax.config import Checkpoint, Compute, InputError, Settings
from slcs2_jax.config.arguments import whole
from slcs2_jax.config.field import show
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.results import FinishedRun, SavedSolution
from slcs2_jax.results.archive import read_archive
from slcs2_jax.results.run_config import read_config
from slcs2_jax.results.run_folder import CHECKPOINT, CHECKPOINT_FORMAT, read_grammar
from slcs2_jax.search.member import Member
from slcs2_jax.search.packing import part_of, unpack_held


def as_saved(member: Member, settings: Settings, grammar_text: str, seed: int) -> SavedSolution:
    """A member as it is written to a file, by the settings of its run and its instance's seed."""
    evaluation, solution = member.evaluation, member.solution
    learnt = evaluation.figures.arrays() | {"usage": np.rint(evaluation.figures.usage).astype(np.int32)}
    return SavedSolution(
        rules=solution.rules,
        **learnt,
        contribution=evaluation.contribution.astype(np.float32),
        # equal runs have equal bytes wherever they lie and whatever computed and saved them
        settings=dataclasses.replace(settings, run_dir=None, compute=Compute(), checkpoint=Checkpoint()),
        grammar_text=grammar_text,
        instance_seed=seed,
        generation=member.generation,
        fitness=member.fitness,
        deployments=evaluation.deployments,
        origin_kind=solution.origin_kind,
        origin_generation=solution.origin_generation,
        origin_agent=solution.origin_agent,
    )


def saved_last(run: FinishedRun, instance: int) -> tuple[SavedSolution | None, list[SavedSolution]]:
    """Best solution and members in the checkpoint of a run under way; None and none before the first save.

    Raises InputError: no such instance, or a damaged file.
    """
    instance = whole("instance", instance, 0, run.settings.instances - 1)
    file = run.path / CHECKPOINT
    if not file.exists():
        return None, []
    try:
        arrays, about = read_archive(file, CHECKPOINT_FORMAT)
        meta = about["instances"][instance]
        members, best = unpack_held(part_of(arrays, f"{instance}.search"), meta["search"], Vocabulary.current())
        grammar, seed = read_grammar(run.path, read_config(run.path)), int(meta["seed"])

        def saved(member: Member) -> SavedSolution:
            return as_saved(member, run.settings, grammar, seed)

        return None if best is None else saved(best), [saved(member) for member in members]
    except (InputError, LookupError, ValueError, TypeError, AttributeError, struct.error, zlib.error) as error:
        raise InputError(f"{file}: {show(str(error))}; slcs2 resume {run.path} says what can be done") from None
