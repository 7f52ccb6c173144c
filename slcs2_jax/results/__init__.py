"""What runs leave behind: the run folder, saved solutions, summaries; and what is shown while they go on. No JAX."""

from slcs2_jax.results.progress import Progress, Quiet, Report
from slcs2_jax.results.reading import FinishedRun, read_run
from slcs2_jax.results.run_folder import RunFolder, check_free, check_usable
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
    "check_usable",
    "load_solution",
    "read_run",
]
