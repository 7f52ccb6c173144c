"""The scripts that make files for publication out of finished runs."""

import os
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import slcs2_jax as slcs2
from slcs2_jax.config import Knowledge, Rules, Search, Settings, Swarm, World
from slcs2_jax.results.rows import parse_row, row_line
from slcs2_jax.results.swarms import swarm_file
from slcs2_jax.study.report import write_report

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def script(name, *arguments):
    command = [sys.executable, SCRIPTS / name, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_same_runs_are_the_same_archive_and_give_the_same_report(make, tmp_path):
    for arm in ("slcs2", "ailta"):
        for seed in range(2):
            make.evolved(arm, "open_short", seed, [0.1, 0.2 + seed], fresh=0.15)
    write_report(make.root, tmp_path / "report")
    make.evolved("slcs2", "open_short", 7, [0.1], planned=2)  # has not ended
    for name in ("first.tar.bz2", "second.tar.bz2"):
        for file in make.root.rglob("*"):
            os.utime(file, (len(name), len(name)))  # when they were written is no part of them
        done = script("archive_runs.py", make.root, tmp_path / name)
        assert done.returncode == 0, done.stderr
        assert done.stdout.startswith("4 runs, ")
    assert (tmp_path / "first.tar.bz2").read_bytes() == (tmp_path / "second.tar.bz2").read_bytes()
    with tarfile.open(tmp_path / "first.tar.bz2") as archive:
        archive.extractall(tmp_path / "unpacked", filter="data")
    write_report(tmp_path / "unpacked" / make.root.name, tmp_path / "again")
    for name in ("contributions_fitness.csv", "verdicts.json"):
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "report" / name).read_bytes()


def test_nothing_outside_a_run_is_archived_or_shipped(make, tmp_path):
    run = make.evolved("slcs2", "open_short", 0, [0.1], fresh=0.15)
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "secret_best.npz").write_bytes(b"secret")
    (run / "solutions").symlink_to(tmp_path / "outside")
    done = script("archive_runs.py", make.root, tmp_path / "out.tar.bz2")
    assert done.returncode == 1
    assert "solutions is a link; accepted is a folder" in done.stderr
    assert not (tmp_path / "out.tar.bz2").exists()
    done = script("ship_swarms.py", make.root)
    assert done.returncode == 1
    assert "solutions is a link; accepted is a folder" in done.stderr


def test_archived_runs_come_to_the_same_again_or_are_named(tmp_path):
    world = World(environment="open", distance=120.0, time_limit=120)
    for seed in range(2):
        settings = Settings(
            world=world, rules=Rules(rules=14), swarm=Swarm(agents=3, packets=4), seed=seed, instances=1,
            knowledge=Knowledge(mode="reflex"), search=Search(generations=2, fresh_deployments=1, max_redeployments=0),
            run_dir=str(tmp_path / "runs" / f"seed_{seed}"),
        )  # fmt: skip
        slcs2.evolve(settings)
    assert script("archive_runs.py", tmp_path / "runs", tmp_path / "runs.tar.bz2").returncode == 0
    done = script("repeat_runs.py", tmp_path / "runs.tar.bz2")
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "2 of 2 came to the same bytes"), done.stderr
    made = script("archive_runs.py", tmp_path / "runs", tmp_path / "thin.tar.bz2", "--without", "contribution")
    assert made.returncode == 0, made.stderr
    with tarfile.open(tmp_path / "thin.tar.bz2") as archive:
        assert all(b"contribution" not in row for row in archive.extractfile("runs/seed_0/generations.jsonl"))
    done = script("repeat_runs.py", tmp_path / "thin.tar.bz2")
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "2 of 2 came to the same bytes"), done.stderr
    rows = tmp_path / "runs" / "seed_1" / "generations.jsonl"
    first, *others = rows.read_bytes().splitlines(keepends=True)
    rows.write_bytes(b"".join([row_line(parse_row(first) | {"best": 0.5}), *others]))
    assert script("archive_runs.py", tmp_path / "runs", tmp_path / "other.tar.bz2").returncode == 0
    done = script("repeat_runs.py", tmp_path / "other.tar.bz2", "--count", 2)
    assert done.returncode == 1
    assert "runs/seed_1: 1 files differ\n" in done.stdout
    assert done.stdout.endswith("1 of 2 came to the same bytes\n")


def test_the_swarm_that_ships_is_the_best_by_fresh_deployments(make):
    for seed, fresh in enumerate([0.2, 0.4, 0.3]):
        run = make.evolved("slcs2", "urban_long", seed, [0.9 - seed], fresh=fresh)
        (run / "solutions").mkdir()
        shutil.copy(swarm_file("long_urban"), run / "solutions" / "instance_000_best.npz")
    before = swarm_file("long_urban").read_bytes()
    done = script("ship_swarms.py", make.root)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "long_urban: 0.400, slcs2/urban_long/seed_001/solutions/instance_000_best.npz\n"
    assert swarm_file("long_urban").read_bytes() == before


def test_no_folder_of_runs(tmp_path):
    for name, more in (("archive_runs.py", [tmp_path / "out.tar.bz2"]), ("ship_swarms.py", [])):
        done = script(name, tmp_path / "nowhere", *more)
        assert done.returncode == 1
        assert "no such folder" in done.stderr
        assert "Traceback" not in done.stderr
