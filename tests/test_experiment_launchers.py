"""Launchers: an experiment comes to the same bytes in one batch, in processes, in jobs of a queue and on Ray."""

import importlib.util
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

COMMAND = (
    "experiment", "contributions", "arm=full", "environment=open,urban", "range=short", "instances=2", "generations=2",
    "world.time_limit=200", "swarm.agents=2", "rules.rules=5", "search.fresh_deployments=1", "compute.devices=1",
)  # fmt: skip
LAUNCHERS = {
    "joblib": ("hydra_plugins.hydra_joblib_launcher", ("hydra.launcher.n_jobs=2",)),
    "submitit_local": ("hydra_plugins.hydra_submitit_launcher", ()),
    "ray": (
        "hydra_plugins.hydra_ray_launcher",
        ("+hydra.launcher.ray.init.num_cpus=2", "+hydra.launcher.ray.init.include_dashboard=false"),
    ),
}


def slcs2(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    found = subprocess.run(
        [sys.executable, "-m", "slcs2_jax", *arguments],
        cwd=folder,
        env={**os.environ, "RAY_USAGE_STATS_ENABLED": "0"},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert found.returncode == 0, found.stderr
    return found


def results(root: Path) -> dict[str, bytes]:
    """What equal runs have in common: all but when, where and by what they were made."""
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("seed_*/**/*"))
        if path.is_file() and path.name not in ("config.yaml", "timing.json", "checkpoint.npz")
    }


@pytest.fixture(scope="module")
def batched(tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("batched")
    slcs2(folder, *COMMAND, "run_dir=root")
    return results(folder / "root")


def test_a_killed_experiment_goes_on_to_the_same_results(tmp_path):
    command = [*COMMAND, "generations=300", "environment=open", "checkpoint.seconds=0"]
    slcs2(tmp_path, *command, "run_dir=whole")
    rows = tmp_path / "killed" / "slcs2" / "open_short" / "seed_000" / "generations.jsonl"
    process = subprocess.Popen(
        [sys.executable, "-m", "slcs2_jax", *command, "run_dir=killed"], cwd=tmp_path, stderr=subprocess.DEVNULL
    )
    while process.poll() is None and not (rows.exists() and rows.read_bytes().count(b"\n") > 20):
        time.sleep(0.01)
    process.kill()
    assert process.wait() == -9  # and not 0: it had not ended
    slcs2(tmp_path, *command, "run_dir=killed")
    assert results(tmp_path / "killed") == results(tmp_path / "whole")


@pytest.mark.parametrize("launcher", LAUNCHERS)
def test_the_same_results(launcher, batched, tmp_path):
    plugin, options = LAUNCHERS[launcher]
    if importlib.util.find_spec(plugin) is None:
        pytest.skip(f"{plugin} is not installed")
    slcs2(tmp_path, *COMMAND, "run_dir=root", f"hydra/launcher={launcher}", *options)
    found = results(tmp_path / "root")
    assert len([name for name in found if name.endswith("summary.json")]) == 4
    assert found == batched
    assert (tmp_path / "root" / "report" / "report.md").exists()
    # repeated without the launcher, nothing is left to do
    again = slcs2(tmp_path, *COMMAND, "run_dir=root")
    assert "4 of the runs are finished" in again.stderr
