"""What runs leave behind: the run folder, saved solutions, summaries; and what is shown while they go on. No JAX."""

from slcs2_jax.results.progress import Progress, Quiet, Report
from slcs2_jax.results.run_folder import FinishedRun, RunFolder, check_free, read_run
from slcs2_jax.results.saved import SavedSolution, load_solution
from slcs2_jax.results.summary import EvaluationSummary, InstanceSummary, RunSummary, ScenarioSummary

__all__ = [
    "EvaluationSummary",
    "FinishedRun",
    "InstanceSummary",
    "Progress",
    "Quiet",
    "Report",
    "RunFolder",
    "RunSummary",
    "SavedSolution",
    "ScenarioSummary",
    "check_free",
    "load_solution",
    "read_run",
]
