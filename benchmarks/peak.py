"""The arithmetic's limit: how many operations a time-step takes, and how many of them this machine can make."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from pathlib import Path

from slcs2_jax.config import Settings
from slcs2_jax.native import build

WIDTHS = (4, 8, 16)  # lanes
ROUNDS, REPEATS = 5_000_000, 3

# Operations (an addition, multiplication, comparison, selection or shift of one number each), counted in the formulas
# of slcs2_jax/native: links.h, elementary.h and randomness.h; classifier.h and mind.h; roles.h; reward.h, strength.h.
LINK = 5 + 1 + 38 + 2 + 75 + 2 + 21  # distance, floor, log2, path loss, normal deviate, its weight, power of two
RULE = 1 + 2 + 15 + 1 + 2  # best ahead, range, ticket, greatest ticket, and whether it holds:
WORD = 2  # for every word of a condition
NODE = 20  # an agent's sight of a node: distance, roles, the closest of each
AGENT = 2 * 45 + 30  # two logarithms of the reward, motion and traffic


def operations(settings: Settings, words: int) -> int:
    """Of one time-step of one episode in the open, at the least: all links drawn, all rules matched and chosen from."""
    n, rules = settings.swarm.agents, settings.rules.rules
    links = (n + 2) * (n + 1) // 2
    return links * LINK + n * rules * (RULE + words * WORD) + n * (n + 2) * NODE + n * AGENT


def peak() -> float:
    """Operations per second of one core: of vectors of the best width, multiplied and added without waiting.

    Raises BuildError if there is no compiler.
    """
    source = Path(__file__).with_suffix(".cc")
    level = build.level()
    architecture = () if level is None else (f"-march={level}",)
    best = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for width in WIDTHS:
            library = Path(folder) / f"peak{width}.so"
            flags = [*build.FLAGS, *architecture, f"-DSLCS2_LANES={width}", "-I", str(build.HERE)]
            command = [build.compiler(), *flags, str(source), "-o", str(library)]
            made = subprocess.run(command, capture_output=True, text=True, timeout=build.SECONDS, check=False)
            if made.returncode:
                raise build.BuildError(f"{command[0]} fails ({made.stderr.strip()[:200]})")
            call = ctypes.CDLL(str(library)).peak
            call.restype, call.argtypes = ctypes.c_double, [ctypes.c_long]
            best = max(best, *(call(ROUNDS) for _ in range(REPEATS)))
    return best
