"""A run that is interrupted, or told to go further, comes to the same bytes as one made at once."""

from __future__ import annotations

import contextlib
import dataclasses
import shutil
import signal
import subprocess
import sys
import threading

import pytest

from slcs2_jax.config import Checkpoint, Compute, InputError, World
from slcs2_jax.results import Quiet, read_run
from slcs2_jax.results.lock import FolderLock
from slcs2_jax.results.sweep import runs_below, write_sweep
from slcs2_jax.running import driver
from slcs2_jax.running.stopping import Stopped, StopRequest


class Raiser(Quiet):
    """Does something at the given call."""

    def __init__(self, call: int, action) -> None:
        self.left, self.action = call, action
        self.seen: list[list[int]] = []

    def generation(self, *, done, best, evaluations, env_steps) -> None:
        self.seen.append(list(done))
        self.left -= 1
        if self.left == 0:
            self.action()


class Crash(BaseException):
    """Nobody expects it: what is on the disk is all there is."""


def crash() -> None:
    raise Crash


def test_a_run_that_crashes_again_and_again_ends_with_the_same_bytes(tiny_run, finished, tmp_path):
    expected = tiny_run.results(finished)
    settings = tiny_run.settings(tmp_path / "run")
    crashes = 0
    for call in range(1, 100):
        try:
            driver.evolve([settings], report=Raiser(4 + call % 3, crash))  # an episode takes three chunks
        except Crash:
            crashes += 1
            continue
        break
    assert crashes >= 2
    assert tiny_run.results(tmp_path / "run") == expected


@pytest.mark.parametrize("call", [1, 2, 4, 7])
def test_one_crash_at_any_time(tiny_run, finished, tmp_path, call):
    settings = tiny_run.settings(tmp_path / "run")
    with pytest.raises(Crash):
        driver.evolve([settings], report=Raiser(call, crash))
    watch = Raiser(0, crash)
    driver.evolve([settings], report=watch)
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)
    if call == 7:
        assert min(watch.seen[0]) > 0, "it began anew"


def test_without_any_checkpoint_the_run_begins_anew(tiny_run, finished, tmp_path):
    settings = tiny_run.settings(tmp_path / "run", checkpoint=Checkpoint(generations=None, seconds=None))
    with pytest.raises(Crash):
        driver.evolve([settings], report=Raiser(5, crash))
    assert not (tmp_path / "run" / "checkpoint.npz").exists()
    driver.evolve([settings])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


@pytest.mark.parametrize("first", [1, 2])
def test_a_run_that_goes_further_equals_one_that_went_so_far_at_once(tiny_run, finished, tmp_path, first):
    driver.evolve([tiny_run.settings(tmp_path / "run", generations=first)])
    [summary] = driver.evolve([tiny_run.settings(tmp_path / "run")])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)
    assert summary.generations == 3
    assert read_run(tmp_path / "run").settings.search.generations == 3


def test_the_order_in_which_rows_came_does_not_show_in_the_end(tiny_run, finished, tmp_path):
    with pytest.raises(Crash):
        driver.evolve([tiny_run.settings(tmp_path / "run")], report=Raiser(7, crash))
    file = tmp_path / "run" / "generations.jsonl"
    lines = file.read_bytes().splitlines(keepends=True)
    assert len(lines) > 1
    file.write_bytes(b"".join(reversed(lines)))  # as they would have come beside other runs
    driver.evolve([tiny_run.settings(tmp_path / "run")])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


def test_solutions_that_only_the_shorter_run_had_go(tiny_run, finished, tmp_path):
    driver.evolve([tiny_run.settings(tmp_path / "run", generations=2)])
    solutions = tmp_path / "run" / "solutions"
    for end in ("npz", "txt"):
        shutil.copy(solutions / f"instance_000_best.{end}", solutions / f"instance_000_member_077.{end}")
    driver.evolve([tiny_run.settings(tmp_path / "run")])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


def test_a_finished_run_is_returned_and_not_touched(tiny_run, finished):
    before = {path: path.stat().st_mtime_ns for path in [finished, *finished.rglob("*")]}
    watch = Raiser(0, crash)
    [again] = driver.evolve([tiny_run.settings(finished)], report=watch)
    assert watch.seen == []
    assert again.to_json() == read_run(finished).summary
    assert {path: path.stat().st_mtime_ns for path in [finished, *finished.rglob("*")]} == before


def test_finished_interrupted_shorter_and_new_runs_go_on_together(tiny_run, tmp_path):
    def of(name: str, seed: int, **values):
        return tiny_run.settings(tmp_path / name, seed=seed, instances=1, **values)

    driver.evolve([of("expected", 0) if seed == 0 else of(f"expected{seed}", seed) for seed in range(4)])
    driver.evolve([of("a0", 0), of("a1", 1, generations=1)])
    with pytest.raises(Crash):
        driver.evolve([of("a2", 2)], report=Raiser(4, crash))
    summaries = driver.evolve([of(f"a{seed}", seed) for seed in (3, 1, 0, 2)])
    assert [one.instances[0].seed for one in summaries] == [3, 1, 0, 2]
    for seed, name in enumerate(["expected", "expected1", "expected2", "expected3"]):
        assert tiny_run.results(tmp_path / f"a{seed}") == tiny_run.results(tmp_path / name)


@pytest.mark.slow
def test_walls_of_runs_that_share_the_batch_no_more_do_not_matter(tiny_run, tmp_path):
    def of(name: str, seed: int, **values):
        world = dataclasses.replace(World.preset("urban"), distance=120.0, time_limit=60, building_spacing=8.0)
        return tiny_run.settings(tmp_path / name, seed=seed, instances=1, world=world, **values)

    driver.evolve([of(f"expected{seed}", seed) for seed in range(4)])
    for seeds in ((0, 1, 2, 3), (2,), (1, 3), (0,)):
        with contextlib.suppress(Crash):
            driver.evolve([of(f"run{seed}", seed) for seed in seeds], report=Raiser(4, crash))
    driver.evolve([of(f"run{seed}", seed) for seed in (0, 3)])
    driver.evolve([of(f"run{seed}", seed) for seed in (1, 2)])
    for seed in range(4):
        assert tiny_run.results(tmp_path / f"run{seed}") == tiny_run.results(tmp_path / f"expected{seed}")


def test_another_number_of_devices_gives_the_same_bytes(tiny_run, finished, tmp_path):
    settings = tiny_run.settings(tmp_path / "run")
    with pytest.raises(Crash):
        driver.evolve([settings], report=Raiser(4, crash))
    with pytest.raises(InputError, match=r"compute.chunk=40: .* already holds a run with compute.chunk=20"):
        driver.evolve([dataclasses.replace(settings, compute=Compute(devices=1, chunk=40))])
    driver.evolve([dataclasses.replace(settings, compute=Compute(devices=2, chunk=20))])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


def test_where_a_run_lies_does_not_matter(tiny_run, finished, tmp_path):
    with pytest.raises(Crash):
        driver.evolve([tiny_run.settings(tmp_path / "here")], report=Raiser(4, crash))
    (tmp_path / "here").rename(tmp_path / "there")
    settings, _ = runs_below(tmp_path)
    driver.evolve(settings)
    assert tiny_run.results(tmp_path / "there") == tiny_run.results(finished)


# -- signals -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_saves_everything_and_says_how_to_go_on(tiny_run, finished, tmp_path, number, code, capfd):
    never = Checkpoint(generations=None, seconds=None)
    settings = tiny_run.settings(tmp_path / "run", checkpoint=never)
    before = signal.getsignal(number)
    watch = Raiser(5, lambda: signal.raise_signal(number))
    with pytest.raises(Stopped, match=f"stopped by {number.name}, and all is saved.* slcs2 resume .*run") as stopped:
        driver.evolve([settings], report=watch)
    assert stopped.value.code == code
    assert signal.getsignal(number) is before
    assert "a second Ctrl-C stops at once" in capfd.readouterr().err
    again = Raiser(0, crash)
    driver.evolve([settings], report=again)
    assert again.seen[0] >= watch.seen[-1], "something that was computed was lost"
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


def test_a_stop_names_the_folder_that_holds_all_runs(tiny_run, tmp_path):
    settings = [tiny_run.settings(tmp_path / "it's all" / name, seed=seed) for seed, name in enumerate("ab")]
    with pytest.raises(Stopped, match=r"resume '.*all'$"):
        driver.evolve(settings, report=Raiser(1, lambda: signal.raise_signal(signal.SIGINT)))
    with pytest.raises(Stopped, match="nothing is kept without run_dir"):
        driver.evolve([tiny_run.settings(None)], report=Raiser(1, lambda: signal.raise_signal(signal.SIGINT)))


BUSY = """\
import hashlib
from slcs2_jax.running.stopping import StopRequest
with StopRequest():
    print("busy", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # a minute at least, without a look at signals
"""


def test_a_second_ctrl_c_stops_at_once_even_if_python_is_not_running():
    with subprocess.Popen([sys.executable, "-c", BUSY], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        while b"a second Ctrl-C stops at once" not in process.stderr.readline():
            pass
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 130


def test_signals_are_left_alone_outside_of_the_main_thread():
    def look() -> None:
        with StopRequest() as stop:
            found.append((stop.number, signal.getsignal(signal.SIGINT)))

    found: list = []
    before = signal.getsignal(signal.SIGINT)
    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert found == [(None, before)]


# -- refusals ----------------------------------------------------------------------------------------------------------


def test_a_folder_that_somebody_works_in_is_refused(tiny_run, finished, tmp_path):
    settings = tiny_run.settings(tmp_path / "run")
    with pytest.raises(Crash):
        driver.evolve([settings], report=Raiser(4, crash))
    before = tiny_run.results(tmp_path / "run")
    with FolderLock(tmp_path / "run"), pytest.raises(InputError, match=r"run_dir=.*: process \d+ on .* works in it"):
        driver.evolve([settings])
    assert tiny_run.results(tmp_path / "run") == before
    (tmp_path / "run" / "lock").write_text('{"host": "gone", "pid": 1}')  # what a dead process leaves
    driver.evolve([settings])
    assert tiny_run.results(tmp_path / "run") == tiny_run.results(finished)


def test_fewer_generations_than_there_are_is_refused(tiny_run, finished):
    with pytest.raises(InputError, match=r"generations=2: .*already holds a run with generations=3"):
        driver.evolve([tiny_run.settings(finished, generations=2)])


def test_a_grammar_that_was_changed_meanwhile_is_refused(tiny_run, tmp_path):
    from slcs2_jax.config import Rules
    from slcs2_jax.grammar import load_grammar

    file = tmp_path / "mine.bnf"
    text = load_grammar("main").text
    file.write_text(text)
    settings = tiny_run.settings(tmp_path / "run", rules=Rules(rules=6, grammar=str(file)))
    with pytest.raises(Crash):
        driver.evolve([settings], report=Raiser(4, crash))
    file.write_text(text + "\n")
    with pytest.raises(InputError, match=r"mine.bnf: is not what it was when the run in .* was started"):
        driver.evolve([settings])
    file.unlink()
    driver.evolve([settings])
    assert read_run(tmp_path / "run").best(0).grammar_text == text


def test_a_run_of_another_search_is_refused(tiny_run, tmp_path):
    settings = tiny_run.settings(tmp_path / "run")
    other = dataclasses.replace(settings, search=dataclasses.replace(settings.search, name="random"))
    with pytest.raises(Crash):
        driver.evolve([other], report=Raiser(4, crash))
    with pytest.raises(InputError, match=r"search\.name=slcs2: .* already holds a run with search\.name=random"):
        driver.evolve([settings])


def test_runs_of_a_sweep_that_had_not_begun_are_known(tiny_run, tmp_path):
    runs = [tiny_run.settings(tmp_path / f"s{seed}", seed=seed, instances=1) for seed in range(3)]
    write_sweep(tmp_path, runs)
    driver.evolve(runs[1:2])
    found, others = runs_below(tmp_path)
    assert (found, others) == (runs, 0)
    longer = [dataclasses.replace(one, search=dataclasses.replace(one.search, generations=4)) for one in runs]
    write_sweep(tmp_path, longer[:2])
    assert runs_below(tmp_path)[0] == [*longer[:2], runs[2]]
