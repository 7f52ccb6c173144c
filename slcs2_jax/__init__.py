"""SLCS2 (arXiv 1910.12412) in JAX: swarms that learn to carry packets, their rules evolved.

What a notebook needs stands here, by name: settings, scenarios, grammars, rule-sets, `deploy`, `evolve`, `evaluate`,
and what reads results. A name is imported when it is first used, so importing the package does not start JAX.

"Model N" in these files is section N of docs/model.md, which says what is computed, and how the paper is read.
"""

from importlib import import_module
from typing import Any

__version__ = "0.2.0"

_HOMES = {
    "slcs2_jax.config": (
        "Checkpoint",
        "Compute",
        "InputError",
        "Jammers",
        "Knowledge",
        "Learning",
        "Radio",
        "Rules",
        "Search",
        "Settings",
        "StorageError",
        "Swarm",
        "Task",
        "World",
        "settings_table",
    ),
    "slcs2_jax.config.chosen": ("with_search",),
    "slcs2_jax.config.registry": ("register",),
    "slcs2_jax.env": ("AutoReset", "Env", "make"),
    "slcs2_jax.policy.bound": ("BoundPolicy", "bind", "bind_list", "bind_rules"),
    "slcs2_jax.policy.decision_list": ("load_decision_list", "parse_decision_list"),
    "slcs2_jax.policy.network": ("Network",),
    "slcs2_jax.policy.policy": ("Policy",),
    "slcs2_jax.swarm.intent": ("collect", "move", "send"),
    "slcs2_jax.swarm.task": ("Delivery", "Score"),
    "slcs2_jax.grammar": ("RuleSets", "load_grammar", "random_rule_sets"),
    "slcs2_jax.world.scenario": ("Scenario", "make_scenario"),
    "slcs2_jax.looking.solutions": ("animate", "replay"),
    "slcs2_jax.results": ("Progress", "SavedSolution", "load_solution", "read_run"),
    "slcs2_jax.api": ("deploy", "evaluate", "evolve"),
    "slcs2_jax.running.evaluator": ("Evaluator",),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = ["__version__", *sorted(_HOME)]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value  # found without a detour from now on
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
