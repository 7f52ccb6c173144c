"""The Hydra launcher `batched` of slcs2_jax: the jobs of a sweep are composed and then given together to the program.

The program advances them in one device batch, which is why its sweeps are faster than their runs one by one. The file
stands here, without an __init__.py beside it, because Hydra takes plugins only from the namespace hydra_plugins.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

from hydra.core.config_store import ConfigStore
from hydra.core.hydra_config import HydraConfig
from hydra.core.utils import JobReturn, JobStatus, setup_globals
from hydra.plugins.launcher import Launcher
from omegaconf import open_dict


class BatchedLauncher(Launcher):
    """Composes every job, then calls the task function's attribute `together` once with all of them.

    `together` takes a list of (configuration, overrides) and returns a number for each.
    """

    def setup(self, *, hydra_context: Any, task_function: Any, config: Any) -> None:
        self.hydra_context, self.task_function, self.config = hydra_context, task_function, config

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> Sequence[JobReturn]:
        setup_globals()
        together = getattr(self.task_function, "together", None)
        if together is None:
            raise TypeError("the launcher 'batched' runs only programs that take several jobs at once, such as slcs2")
        returns, jobs = [], []
        before = HydraConfig.instance().cfg
        try:
            for number, overrides in enumerate(job_overrides, start=initial_job_idx):
                config = self.hydra_context.config_loader.load_sweep_config(self.config, list(overrides))
                with open_dict(config):
                    config.hydra.job.id = config.hydra.job.num = number
                HydraConfig.instance().set_config(config)
                task = copy.deepcopy(config)
                with open_dict(task):
                    del task["hydra"]
                typed = list(config.hydra.overrides.task)
                jobs.append((task, typed))
                returns.append(JobReturn(overrides=typed, cfg=task, hydra_cfg=config, status=JobStatus.COMPLETED))
            for job, value in zip(returns, together(jobs), strict=True):
                job.return_value = value
        finally:
            HydraConfig.instance().cfg = before
        return returns


ConfigStore.instance().store(
    group="hydra/launcher",
    name="batched",
    node={"_target_": f"{__name__}.{BatchedLauncher.__name__}"},
    provider="slcs2_jax",
)
