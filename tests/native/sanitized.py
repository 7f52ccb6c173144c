"""A few steps of every kind by one library, for `scripts/sanitize`: python -m tests.native.sanitized LIBRARY."""

from __future__ import annotations

import os
import sys

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from slcs2_jax.policy.first_match import FirstMatch
from tests.native.episodes import make
from tests.native.plain import Plain, joined

CASES = [  # environment, grammar, agents, rules, batch, periods
    ("open", "main", 12, 100, 16, 5),
    ("urban_jammed", "both", 12, 100, 11, 5),
    ("urban", "power", 2, 1, 3, 5),
    ("jammed", "channel", 37, 65, 8, 2),
    ("urban_jammed", "both", 64, 1000, 1, 1),
]


def main(path: str) -> None:
    """Raises nothing, prints the cases: the sanitizers end the process."""
    library = Plain(path)
    for environment, grammar, agents, rules, batch, periods in CASES:
        for policy in (None, FirstMatch()):
            episode, parameters = make(
                environment, grammar, agents=agents, rules=rules, batch=batch, policy=policy, time_limit=25
            )
            for noted in (False, True):
                kept = library.advance(episode, parameters, periods, noted=noted)
            if policy is None:
                library.finish(joined(kept, episode), parameters)
            print(environment, grammar, agents, rules, batch, "decision list" if policy else "classifier", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
