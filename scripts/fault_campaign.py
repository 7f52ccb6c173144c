"""The long form of tests/faults:

    python scripts/fault_campaign.py --kills 50 --damages 2000 --inputs 100000 --hostile 500 --out FILE

Kills commands at random moments and lets them go on, lets every write of a run fail, damages files of run folders,
feeds random settings, texts and bytes, and lets every command loose on folders that a stranger could have sent; prints
what was found and writes it as JSON. Exit code 0 if nothing differed, was lost, was believed wrongly, took too much, or
touched anything outside.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--kills",
        type=int,
        default=50,
        help="kills, over evolve with the paper's parts and others, informed search, sweep, experiment, transfer, "
        "trainings of networks, and suites",
    )
    parser.add_argument("--damages", type=int, default=2000, help="damaged files")
    parser.add_argument("--inputs", type=int, default=100_000, help="random inputs for each property; 0: none")
    parser.add_argument("--hostile", type=int, default=500, help="hostile folders; 0: none")
    parser.add_argument("--only", default="", help="regular expression: of kills and hostile folders those it is in")
    parser.add_argument("--seed", type=int, default=0, help="of the chance")
    parser.add_argument("--folder", type=Path, help="where the runs go (a temporary folder)")
    parser.add_argument("--out", type=Path, help="JSON file for the figures")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="slcs2-faults-") as scratch:
        figures = campaign(options, options.folder or Path(scratch))
    text = json.dumps(figures, indent=2)
    if options.out:
        options.out.write_text(text + "\n", encoding="utf-8")
    print(text)
    print("\n".join(report(figures)))
    return 0 if clean(figures) else 1


def campaign(options: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """All parts, each with its figures and the seconds it took."""
    import jax

    jax.config.update("jax_num_cpu_devices", 1)
    from fault_campaign_damage import damage
    from fault_campaign_kills import kills

    figures: dict[str, Any] = {"seed": options.seed}
    chosen = functools.partial(kills, only=options.only)
    for name, count, part in (("kills", options.kills, chosen), ("damages", options.damages, damage)):
        start = time.monotonic()
        (folder / name).mkdir(parents=True)
        found = asdict(part(count, folder / name, seed=options.seed)) if count else {}
        figures[name] = {"count": count, **found, "seconds": round(time.monotonic() - start)}
    for name, tests, setting in (
        ("writes", ["test_writes.py"], {"SLCS2_FAULTS_EVERY": "1"}),
        ("inputs", ["test_inputs.py", "test_texts.py"], {"SLCS2_INPUTS": str(options.inputs)}),
    ):
        start = time.monotonic()
        if options.inputs:
            passed = _pytest(tests, setting)
            figures[name] = {"count": options.inputs, "passed": passed, "seconds": round(time.monotonic() - start)}
    if options.hostile:
        start = time.monotonic()
        found = _hostile(options.hostile, folder / "hostile", options.seed, options.only)
        figures["hostile"] = {"count": options.hostile, **found, "seconds": round(time.monotonic() - start)}
    return figures


def _hostile(count: int, folder: Path, seed: int, only: str = "") -> dict[str, Any]:
    """In a process of its own: its commands are forks of one that has not started JAX."""
    command = [sys.executable, ROOT / "scripts" / "fault_campaign_hostile.py", str(count), folder, str(seed), only]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _pytest(files: Sequence[str], environment: dict[str, str]) -> bool:
    tests = [ROOT / "tests" / "faults" / file for file in files]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | environment, check=False)
    return done.returncode == 0


def clean(figures: dict[str, Any]) -> bool:
    """Did everything hold?"""
    kills, damages = figures["kills"], figures["damages"]
    wrong = [
        kills.get("differing"),
        kills.get("lost_generations"),
        kills.get("tracebacks"),
        damages.get("believed"),
        damages.get("tracebacks"),
        figures.get("hostile", {}).get("wrong"),
    ]
    return not any(wrong) and all(figures[name]["passed"] for name in ("writes", "inputs") if name in figures)


def report(figures: dict[str, Any]) -> list[str]:
    """The figures in words."""
    kills, damages = figures["kills"], figures["damages"]
    lines = [
        f"{sum(kills.get('kills', {}).values())} kills: {len(kills.get('differing', []))} files differ, "
        f"{kills.get('lost_generations', 0)} saved generations lost, {len(kills.get('tracebacks', []))} tracebacks",
        f"{damages['count']} damaged files: {damages.get('detected', 0)} detected, "
        f"{damages.get('harmless', 0)} harmless, {len(damages.get('believed', []))} believed, "
        f"{len(damages.get('tracebacks', []))} tracebacks",
    ]
    if "hostile" in figures:
        one = figures["hostile"]
        lines.append(
            f"{one['tried']} commands over hostile folders: {one['refused']} refused, {one['read']} read, at most "
            f"{one['slowest']:.1f} s and {one['largest'] / 2**20:.0f} MB more than usual; {len(one['wrong'])} wrong"
        )
    for name, what in (
        ("writes", "every write fails once"),
        ("inputs", f"{figures.get('inputs', {}).get('count')} inputs"),
    ):
        if name in figures:
            lines.append(f"{what}: {'all held' if figures[name]['passed'] else 'FAILED'}")
    return lines


if __name__ == "__main__":
    sys.exit(main())
