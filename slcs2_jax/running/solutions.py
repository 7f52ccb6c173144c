"""Solutions that a run has made: as they are saved, and as its last checkpoint holds them."""

from __future__ import annotations

import dataclasses

import numpy as np

from slcs2_jax.config import Checkpoint, Compute, InputError, Settings
from slcs2_jax.config.arguments import whole
from slcs2_jax.config.door import present, telling_damage
from slcs2_jax.grammar.vocabulary import Vocabulary
from slcs2_jax.results import FinishedRun, SavedSolution
from slcs2_jax.results.archive import read_archive
from slcs2_jax.results.files import storing
from slcs2_jax.results.run_config import read_config
from slcs2_jax.results.run_folder import CHECKPOINT, CHECKPOINT_FORMAT, checkpoint_limits, read_grammar
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
        settings=dataclasses.replace(settings, run_dir=None, logger="none", compute=Compute(), checkpoint=Checkpoint()),
        grammar_text=grammar_text,
        instance_seed=seed,
        generation=member.generation,
        fitness=member.fitness if evaluation.offset is None else min(1.0, max(-1.0, member.fitness)),
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
    if not present(file):
        return None, []
    prefix, limits = f"{instance}.search", checkpoint_limits(run.settings)
    try:
        with storing(file, "read"):
            arrays, about = read_archive(
                file, CHECKPOINT_FORMAT, limits, wanted=lambda name: name.startswith(f"{prefix}.members.")
            )
        grammar = read_grammar(run.path, read_config(run.path))
        with telling_damage():
            meta = about["instances"][instance]
            members, best = unpack_held(
                part_of(arrays, prefix), meta["search"], Vocabulary.current(run.settings.radio.channels)
            )
            seed = int(meta["seed"])
            saved = [as_saved(member, run.settings, grammar, seed) for member in members]
            return None if best is None else as_saved(best, run.settings, grammar, seed), saved
    except InputError as error:
        raise InputError(f"{file}: {error}; slcs2 resume {run.path} says what can be done") from None
