"""Search for rule-sets: solutions, their evaluation, and the algorithms that propose them. Plain NumPy, no JAX."""

from slcs2_jax.search.ailta import Ailta
from slcs2_jax.search.base import BaseSearch
from slcs2_jax.search.collection import Collection, domination
from slcs2_jax.search.evaluation import Deployment, Evaluation, mean_of
from slcs2_jax.search.fresh import Fresh
from slcs2_jax.search.history import History, HistoryRow
from slcs2_jax.search.informed import Informed
from slcs2_jax.search.keys import deployment_key, fresh_deployment_key
from slcs2_jax.search.knowledge import Knowledge
from slcs2_jax.search.member import Member
from slcs2_jax.search.noise import Noise
from slcs2_jax.search.novelty import NoveltyIndex, novelty
from slcs2_jax.search.offspring import Exchange, offspring
from slcs2_jax.search.parents import FewestExplorations
from slcs2_jax.search.parts import Acceptance, ParentChoice, Variation, Verdict
from slcs2_jax.search.population import Best, Tournament
from slcs2_jax.search.problem import Problem
from slcs2_jax.search.protocol import MakeSearch, Search, SearchState
from slcs2_jax.search.random import RandomSearch
from slcs2_jax.search.slcs2 import Slcs2
from slcs2_jax.search.solution import Origin, Solution
from slcs2_jax.search.starters import Starters
from slcs2_jax.search.supply import RuleSource, RuleSupply
from slcs2_jax.search.trial import Race, Trial, WorldRace, counted

__all__ = [
    "Acceptance",
    "Ailta",
    "BaseSearch",
    "Best",
    "Collection",
    "Deployment",
    "Evaluation",
    "Exchange",
    "FewestExplorations",
    "Fresh",
    "History",
    "HistoryRow",
    "Informed",
    "Knowledge",
    "MakeSearch",
    "Member",
    "Noise",
    "NoveltyIndex",
    "Origin",
    "ParentChoice",
    "Problem",
    "Race",
    "RandomSearch",
    "RuleSource",
    "RuleSupply",
    "Search",
    "SearchState",
    "Slcs2",
    "Solution",
    "Starters",
    "Tournament",
    "Trial",
    "Variation",
    "Verdict",
    "WorldRace",
    "counted",
    "deployment_key",
    "domination",
    "fresh_deployment_key",
    "mean_of",
    "novelty",
    "offspring",
]
