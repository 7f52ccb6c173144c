"""A few steps of every kind by one library, for `scripts/sanitize`: python -m tests.native.sanitized LIBRARY."""

from __future__ import annotations

import os
import sys
from typing import Any

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from slcs2_jax.policy.first_match import FirstMatch
from tests.native.episodes import make, some_jammers
from tests.native.plain import Plain, joined

FAILING: dict[str, Any] = {"failure_rate": 0.02, "recovery_steps": 5, "failures_at": (0, 7), "failure_share": 0.3}
CASES: list[
    tuple[str, str, int, int, int, int, dict[str, Any]]
] = [  # environment, grammar, agents, rules, batch, periods
    ("open", "main", 12, 100, 16, 5, {}),
    ("urban_jammed", "both", 12, 100, 11, 5, {}),
    ("urban", "power", 2, 1, 3, 5, {}),
    ("jammed", "channel", 37, 65, 8, 2, {}),
    ("urban_jammed", "both", 64, 1000, 1, 1, {}),
    ("urban_jammed", "both", 12, 30, 11, 5, {"jammers": some_jammers, **FAILING}),
    ("open", "both", 64, 5, 3, 2, {"jammers": some_jammers, "channels": tuple(range(1, 15))}),
    ("jammed", "main", 3, 9, 9, 3, {"radio": {"fading": "nakagami", "nakagami_m": 0.5}, **FAILING}),
    (
        "open",
        "both",
        5,
        9,
        1,
        3,
        {"channels": (14,), "radio": {"fading": "rician"}, "failure_keeps_packet": True, **FAILING},
    ),
    ("urban", "main", 7, 9, 2, 3, {"radio": {"fading": "rayleigh"}}),
]


def main(path: str) -> None:
    """Raises nothing, prints the cases: the sanitizers end the process."""
    library = Plain(path)
    for environment, grammar, agents, rules, batch, periods, parts in CASES:
        for policy in (None, FirstMatch()):
            episode, parameters = make(
                environment, grammar, agents=agents, rules=rules, batch=batch, policy=policy, time_limit=25, **parts
            )
            for noted in (False, True):
                kept = library.advance(episode, parameters, periods, noted=noted)
            if policy is None:
                library.finish(joined(kept, episode), parameters)
            print(environment, grammar, agents, rules, batch, "decision list" if policy else "classifier", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
