"""Evolution of rule-sets: solutions, evaluation, the collection under novelty domination, offspring, the search."""

from slcs2_jax.search.ailta import Ailta
from slcs2_jax.search.collection import Collection, domination
from slcs2_jax.search.evaluation import (
    Deployment,
    Evaluation,
    Trial,
    counted,
    deployment_key,
    fresh_deployment_key,
    mean_of,
)
from slcs2_jax.search.member import Acceptance, Member, Verdict
from slcs2_jax.search.novelty import NoveltyIndex, novelty
from slcs2_jax.search.offspring import offspring
from slcs2_jax.search.slcs2 import HistoryRow, Search
from slcs2_jax.search.solution import Origin, Solution, initial_solution
from slcs2_jax.search.supply import RuleSource, RuleSupply

__all__ = [
    "Acceptance",
    "Ailta",
    "Collection",
    "Deployment",
    "Evaluation",
    "HistoryRow",
    "Member",
    "NoveltyIndex",
    "Origin",
    "RuleSource",
    "RuleSupply",
    "Search",
    "Solution",
    "Trial",
    "Verdict",
    "counted",
    "deployment_key",
    "domination",
    "fresh_deployment_key",
    "initial_solution",
    "mean_of",
    "novelty",
    "offspring",
]
