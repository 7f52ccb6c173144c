"""The native chunk on an emulated processor: the same bytes? Its arguments: a library for this one, and how to run it.

python -m tests.native.elsewhere LIBRARY COMMAND...
"""

from __future__ import annotations

import os
import subprocess
import sys

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import numpy as np

from slcs2_jax.native.arrays import Sizes, given_arrays, kept_arrays
from slcs2_jax.policy.first_match import FirstMatch
from tests.native.episodes import make
from tests.native.plain import Plain
from tests.native.sanitized import CASES


def main(path: str, *command: str) -> int:
    """How many cases differ."""
    library, differing = Plain(path), 0
    for environment, grammar, agents, rules, batch, periods, parts in CASES:
        for policy in (None, FirstMatch()):
            episode, parameters = make(
                environment, grammar, agents=agents, rules=rules, batch=batch, policy=policy, **parts
            )
            sizes = Sizes.of(episode, parameters, periods)
            arrays = [sizes.as_array(), *given_arrays(episode, parameters), *kept_arrays(episode)]
            call = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
            found = subprocess.run(command, input=call, stdout=subprocess.PIPE, check=True).stdout
            same = found == b"".join(array.tobytes() for array in library.advance(episode, parameters, periods))
            differing += not same
            name = "decision list" if policy else "classifier"
            print(environment, grammar, agents, rules, batch, name, "same" if same else "DIFFERENT", flush=True)
    return differing


if __name__ == "__main__":
    sys.exit(min(1, main(*sys.argv[1:])))
