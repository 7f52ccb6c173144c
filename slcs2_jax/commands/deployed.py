"""Runs of an experiment that evolve nothing: a policy that is there already, deployed in each instance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from slcs2_jax.commands.policies import policy_named
from slcs2_jax.config.errors import InputError

if TYPE_CHECKING:
    from slcs2_jax.study.experiment import Planned

BEHAVIOUR = "behaviour"  # in the record: the text of a decision list, or the digest of a file


def check_deployable(planned: Planned) -> bool:
    """Is the run there already? Raises InputError if its folder holds another, or there is no such behaviour."""
    from slcs2_jax.config.door import present
    from slcs2_jax.results.reading import read_summary
    from slcs2_jax.results.run_config import CONFIG, check_same, read_config
    from slcs2_jax.results.run_folder import check_free
    from slcs2_jax.study.collect import policy_of

    named = policy_named(str(planned.policy))
    folder = Path(str(planned.settings.run_dir))
    if not present(folder / CONFIG):
        check_free(folder)
        return False
    found = read_config(folder)
    if policy_of(found.record) != planned.policy:
        raise InputError(f"run_dir={folder}: already holds another run; accepted is another folder")
    if found.record.get(BEHAVIOUR) != named.content:
        raise InputError(
            f"run_dir={folder}: {planned.policy} was another behaviour when it was deployed there; accepted is "
            "the same one, or another folder"
        )
    check_same(planned.settings, found.settings, folder)
    return read_summary(folder, found) is not None


def deploy(planned: Sequence[Planned]) -> None:
    """Deploy in every instance that lacks it, one cell after the other, as often as winners are deployed afresh."""
    going = [one for one in planned if not check_deployable(one)]
    for _, group in groupby(going, key=lambda one: (one.policy, one.settings.world)):
        _deploy_cell(list(group))


def _deploy_cell(planned: Sequence[Planned]) -> None:
    from slcs2_jax import runtime
    from slcs2_jax.config.door import present
    from slcs2_jax.native.choice import computed_on
    from slcs2_jax.results import Progress, RunFolder
    from slcs2_jax.results.run_config import CONFIG, read_config
    from slcs2_jax.study.collect import DEPLOYED, POLICY

    first = planned[0].settings
    count = first.search.fresh_deployments
    named = policy_named(str(planned[0].policy))
    runtime.configure(first.compute)
    from slcs2_jax.running.driver import deploy_in_runs

    settings = [one.settings for one in planned]
    with Progress(count, label=f"{first.world.range} {first.world.environment}: deployment") as report:
        deployments = deploy_in_runs(settings, named.policy, deployments=count, report=report)
    device = computed_on(first.compute)
    for one, [own] in zip(settings, deployments, strict=True):
        path = Path(str(one.run_dir))
        if present(path / CONFIG):  # interrupted before its figures were written
            folder = RunFolder(path, read_config(path))
        else:
            record = {POLICY: planned[0].policy, BEHAVIOUR: named.content}
            folder = RunFolder.create(one, device=device, record=record)
        folder.write_summary({
            DEPLOYED: [deployment.fitness for deployment in own],
            "delivered": [deployment.delivered for deployment in own],
            "steps": [deployment.steps for deployment in own],
        })  # fmt: skip
