"""Seeds and keys: each gives the random numbers of one use a stream of their own under the same run seed."""

from __future__ import annotations

import numpy as np

from slcs2_jax.config import InputError

PURPOSE_SEARCH, PURPOSE_DEPLOYMENT, PURPOSE_FRESH, PURPOSE_RULES = 1, 2, 3, 4
PURPOSE_NETWORK, PURPOSE_TRAINING = 32, 33

Key = tuple[np.uint32, np.uint32]


def seed_sequence(seed: int, *words: int) -> np.random.SeedSequence:
    """The stream of `seed` (0 <= seed < 2^64) for the given words (each below 2^32), the first of which is a purpose.

    The words go in as a spawn key: as plain entropy a long seed would run into them ([2^32, 5] equals [0, 1, 5]).
    """
    if not 0 <= seed < 2**64:
        raise InputError(f"seed = {seed}; 0 to 2^64 - 1 is accepted")
    return np.random.SeedSequence(seed, spawn_key=words)


def _key(seed: int, *words: int) -> Key:
    key0, key1 = seed_sequence(seed, *words).generate_state(2, np.uint32)
    return key0, key1


def deployment_key(seed: int, generation: int, deployment: int) -> Key:
    """Episode key of one deployment of a generation's solution in the run with this seed."""
    return _key(seed, PURPOSE_DEPLOYMENT, generation, deployment)


def fresh_deployment_key(seed: int, deployment: int) -> Key:
    """Episode key of one of the winner's fresh deployments; no search ever uses these."""
    return _key(seed, PURPOSE_FRESH, deployment)


def training_key(seed: int, episode: int) -> Key:
    """Episode key of one of the episodes that the training with this seed consists of."""
    return _key(seed, PURPOSE_TRAINING, episode)
