"""How the agents of a solution share the work: two numbers by which searches for variety tell solutions apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slcs2_jax.search.evaluation import Evaluation


def sharing(evaluation: Evaluation) -> NDArray[np.float64]:
    """Of the contributions of n agents, float64 [2], each from 0 to 1.

    First the share of the agents that contribute at all: few carry far, or many relay. Second how evenly they do, the
    mean contribution over the greatest. Both are 0 where nothing is delivered.
    """
    contribution = evaluation.contribution
    most = float(contribution.max(initial=0.0))
    if most <= 0:
        return np.zeros(2)
    return np.array([np.count_nonzero(contribution) / len(contribution), contribution.mean() / most])
