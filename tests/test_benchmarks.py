"""The benchmarks count what they say they count, and everybody plays the same. No test asserts a time."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest

from benchmarks import environment, generation, gpu_program, kernels, peak, report, rounds, scaling, throughput
from benchmarks.batch import make_rollout, play
from benchmarks.rounds import Play, Spread
from benchmarks.workload import Workload, median_scenario, random_workload, saved_workload, settings_of, with_walls
from slcs2_jax.config import Compute, InputError
from slcs2_jax.env import make
from slcs2_jax.grammar import load_grammar
from slcs2_jax.native import library

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = {
    "throughput": throughput,
    "scaling": scaling,
    "generation": generation,
    "kernels": kernels,
    "environment": environment,
    "gpu_program": gpu_program,
}
LIMITS = (20, 35, 50)  # steps of the episodes: one, two and three chunks of 20 steps


@pytest.fixture(scope="module")
def workload() -> Workload:
    """Small episodes of different lengths."""
    settings = settings_of("urban/short", agents=3, rules=10, compute=Compute(devices=1, chunk=20, cache=False))
    made = random_workload(settings, len(LIMITS), median=False)
    cut = tuple(made.cut(limit).scenarios[i] for i, limit in enumerate(LIMITS))
    return Workload(made.settings, made.channels, made.language, cut, made.solutions)


class Slots:
    """Stands in for a rollout: job k takes as many steps as it says."""

    steps_per_chunk = 10

    def __init__(self, slots: int) -> None:
        self.slots, self.slot_steps = slots, 0
        self.left: dict[int, list[int]] = {}
        self.useful = 0

    def vacant(self) -> list[int]:
        return [slot for slot in range(self.slots) if slot not in self.left]

    def place(self, slot: int, job: int) -> None:
        assert slot not in self.left
        self.left[slot] = [job, job]

    def cancel(self, slot: int) -> None:
        del self.left[slot]

    def advance(self) -> list[object]:
        self.slot_steps += self.slots * self.steps_per_chunk
        done = []
        for slot, (steps, left) in list(self.left.items()):
            self.useful += min(left, self.steps_per_chunk)
            self.left[slot][1] -= self.steps_per_chunk
            if left <= self.steps_per_chunk:
                del self.left[slot]
                done.append(type("Done", (), {"slot": slot, "steps": steps}))
        return done


@pytest.mark.parametrize("busy", [1, 3, 4])
def test_useful_steps_are_those_of_running_episodes(busy):
    slots = Slots(4)
    lengths = [25, 3, 40, 10, 61, 7, 18, 33]
    found = play(slots, lambda episode: lengths[episode % len(lengths)], busy, 95)  # type: ignore[arg-type,return-value]
    assert found.steps == slots.useful
    assert found.slot_steps == 4 * 100, "ten chunks of ten steps in four slots"
    assert sum(found.lengths) < found.steps, "some were under way at the end"
    assert not slots.left, "the slots are free for the next round"


@pytest.mark.slow
def test_counted_steps_are_those_of_the_episodes_and_peers_make_as_many(workload):
    rollout = make_rollout(workload, 3)
    found = play(rollout, workload.job, 3, 60)
    # chunks of 20 steps: one slot plays 20, 20 and 20 of 35 steps, one 35 (two chunks) and 20 of 50, one 50
    assert sorted(found.lengths) == [20, 20, 35, 50], "random rules deliver nothing so soon: episodes end at limits"
    assert found.steps == sum(found.lengths) + 20 + 20
    first = play(rollout, workload.job, len(LIMITS), 20)
    assert first.lengths == (20,)
    assert first.steps == 60
    pytest.importorskip("numba")
    from benchmarks.peers import Peers

    peers = Peers.of(workload, len(LIMITS), fastmath=False)
    for way in (peers.one_core, peers.all_cores):
        peer = way()
        assert peer.lengths == LIMITS
        assert peer.steps == peer.slot_steps == sum(LIMITS)


def test_everybody_has_the_same_scenarios_rules_and_keys(workload):
    pytest.importorskip("numba")
    from benchmarks.peers import Peers
    from tests.oracle.inputs import unpack_clauses

    peers = Peers.of(workload, 5, fastmath=False)
    assert len({tuple(key) for key in peers.keys}) == 5
    for episode in range(5):
        job, world = workload.job(episode), peers.worlds[episode]
        assert job.scenario is workload.scenarios[episode % len(LIMITS)]
        np.testing.assert_array_equal(world.start, job.scenario.start)
        np.testing.assert_array_equal(world.fixed[1], job.scenario.sink)
        assert (len(world.vertical.line), len(world.horizontal.line)) == (
            len(job.scenario.vertical),
            len(job.scenario.horizontal),
        )
        assert world.time_limit == job.scenario.time_limit
        np.testing.assert_array_equal(unpack_clauses(peers.rules[episode].mask), job.given.mask)
        np.testing.assert_array_equal(peers.rules[episode].action, job.given.action)
        np.testing.assert_array_equal(peers.keys[episode], job.key)


@pytest.mark.slow
def test_plain_python_makes_its_steps_all_along_the_first_episode(workload):
    pytest.importorskip("numba")
    from benchmarks.peers import STRETCHES, Peers

    peers = Peers.of(workload, 1, fastmath=False)
    found = peers.stretches(2)
    assert [t for t, _ in found] == np.linspace(0, LIMITS[0] - 2, STRETCHES).astype(int).tolist()
    assert not np.array_equal(found[0][1].place, found[-1][1].place), "agents have moved on"
    assert peers.plain_python(found, 2).steps == 2 * STRETCHES
    assert peers.plain_python(found, 5).steps < 5 * STRETCHES, "no step beyond the end of the episode counts"


def test_rounds_are_interleaved_and_ratios_taken_round_by_round():
    played = []

    def contestant(name: str, *seconds: float):
        left = list(seconds)

        def once() -> Play:
            played.append(name)
            return Play(left.pop(0), 10, 10, ())

        return once

    plays = rounds.interleave({"a": contestant("a", 1, 2, 4), "b": contestant("b", 2, 2, 16)}, 3)
    assert "".join(played) == "abbaab"
    assert rounds.ratios(plays["a"], plays["b"]) == Spread(median=2, low=1, high=4)


def test_evaluations_per_second_follow_from_the_length_of_whole_episodes():
    plays = {"batch 2": [Play(seconds=2.0, steps=400, slot_steps=800, lengths=(150, 50))]}
    found = throughput.figures("batch 2", plays, 12, to_their_end=True)
    assert found["env_steps_per_second"]["median"] == 200
    assert found["agent_steps_per_second"]["median"] == 2400
    assert found["evaluations_per_second"]["median"] == 2, "200 steps a second, 100 for each"
    assert found["useful_share"] == 0.5
    assert throughput.figures("batch 2", plays, 12, to_their_end=False)["evaluations_per_second"] is None


def test_the_limit_counts_what_grows_with_agents_and_rules():
    one, more, ruled = (
        peak.operations(settings_of("open/short", agents=agents, rules=rules, compute=Compute()), 3)
        for agents, rules in ((12, 100), (24, 100), (12, 200))
    )
    assert 2 * one < more < 4 * one
    assert ruled - one == 12 * 100 * (peak.RULE + 3 * peak.WORD)


def test_the_peak_is_the_best_of_all_widths(monkeypatch):
    monkeypatch.setattr(peak, "ROUNDS", 1000)
    if library.reason_against() is None:
        assert peak.peak() > 1e8


def test_median_scenario_and_exact_numbers_of_walls():
    settings = settings_of("urban/short", compute=Compute())
    walls = sorted(scenario.walls for scenario in random_workload(settings, 101, median=False).scenarios)
    assert median_scenario(settings).walls == walls[50]
    for count in (0, 1, 40):
        scenario = with_walls(settings, count)
        assert scenario.walls == count
    with pytest.raises(InputError, match="walls=5000"):
        with_walls(settings, 5000)


def test_a_saved_solution_plays_in_every_episode(workload, tmp_path):
    from slcs2_jax.results import SavedSolution

    rules, small = workload.solutions[0], np.zeros((3, 10), np.float32)
    saved = SavedSolution(
        rules=rules,
        quality=small,
        strength=small,
        error=small,
        usage=small.astype(np.int32),
        contribution=small[:, 0],
        settings=workload.settings,
        grammar_text=load_grammar("main").text,
        instance_seed=0,
        generation=0,
        fitness=0.0,
        deployments=1,
    )
    saved.save(tmp_path / "one.npz")
    settings = settings_of("urban/short", compute=Compute())
    found = saved_workload(settings, tmp_path / "one.npz", 2, median=True)
    assert (found.settings.swarm.agents, found.settings.rules.rules) == (3, 10)
    for episode in range(3):
        np.testing.assert_array_equal(found.job(episode).given.mask, rules.mask)
        assert found.job(episode).scenario is found.scenarios[0], "all in the median scenario"
    assert found.channels == workload.channels


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0, "0"), (123456, "123,000"), (1.2345, "1.23"), (0.012345, "0.0123"), (-99.96, "-100.0")],
)
def test_figures_have_three_digits(value, text):
    assert report.figure(value) == text


@pytest.mark.parametrize("script", SCRIPTS)
@pytest.mark.parametrize(
    "wrong", [["--nonsense"], ["--devices", "0"], ["--json", "/nowhere/at/all.json"], ["--js", "x"]]
)
def test_bad_flags_end_with_one_line_and_code_2(script, wrong, capsys):
    with pytest.raises(SystemExit) as ended:
        SCRIPTS[script].main(wrong)
    assert ended.value.code == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith(f"python -m benchmarks.{script}: error: ")


@pytest.mark.parametrize(
    ("script", "wrong", "complaint"),
    [
        ("throughput", ["--cells", "moon/short"], "accepted are open/short"),
        ("throughput", ["--batch", "16,16"], "names a value twice"),
        ("throughput", ["--peers", "none,python"], "none stands alone"),
        ("throughput", ["--solution", "nowhere.npz"], "no such file"),
        ("scaling", ["--agents", "1"], "accepted is a whole number from 2 to 64"),
        ("scaling", ["--plot", "picture.gif"], "accepted are names that end in"),
        ("generation", ["--cell", "open"], "accepted are open/short"),
        ("generation", ["--here"], "accepted is one number of instances"),
    ],
)
def test_complaints_say_what_is_accepted(script, wrong, complaint, capsys):
    with pytest.raises(SystemExit) as ended:
        SCRIPTS[script].main(wrong)
    assert ended.value.code == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert complaint in err


@pytest.mark.parametrize("script", SCRIPTS)
def test_help_explains(script, capsys):
    with pytest.raises(SystemExit) as ended:
        SCRIPTS[script].main(["--help"])
    assert ended.value.code == 0
    assert f"python -m benchmarks.{script}" in capsys.readouterr().out


def run(script: str, folder: Path, *arguments: str) -> tuple[str, dict]:
    """What it prints, and its JSON."""
    path = folder / "figures.json"
    command = [sys.executable, "-m", f"benchmarks.{script}", *arguments, "--json", str(path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    figures = json.loads(path.read_text())
    assert figures["command"] == " ".join(["python", *command[1:]])
    assert figures["command"] in done.stdout
    assert figures["machine"]["cores"] >= 1
    assert set(figures["machine"]["versions"]) >= {"slcs2_jax", "python", "jax", "numba", "numpy"}
    assert list(folder.iterdir()) == [path], "nothing is left beside the file"
    return done.stdout, figures


@pytest.mark.slow
def test_throughput_in_small(tmp_path):
    pytest.importorskip("numba")
    out, figures = run(
        "throughput", tmp_path, "--cells", "urban/short", "--batch", "1,16", "--steps", "30", "--repeats", "2",
        "--episodes", "2", "--python-steps", "2", "--agents", "3", "--rules", "10", "--devices", "1", "--no-fastmath",
        "--native", "auto", "--clock", "cpu",
    )  # fmt: skip
    rows = {row["name"]: row for row in figures["tables"]["urban/short"]}
    who = "native" if library.reason_against() is None else "XLA"
    assert list(rows) == [f"{who}, batch 1", f"{who}, batch 16", "numba-all", "numba-one", "python"]
    rows |= {f"batch {size}": rows.pop(f"{who}, batch {size}") for size in (1, 16)}
    assert [played["steps"] for played in rows["batch 1"]["rounds"]] == [30, 30]
    assert [played["steps"] for played in rows["batch 16"]["rounds"]] == [480, 480]
    for peer in ("numba-all", "numba-one"):
        assert [played["lengths"] for played in rows[peer]["rounds"]] == [[30, 30]] * 2
    assert [played["steps"] for played in rows["python"]["rounds"]] == [20, 20]
    assert rows["batch 16"]["useful_share"] == 1
    computed = library.lanes() if library.reason_against() is None else rows["batch 1"]["slots"]
    assert rows["batch 1"]["useful_share"] == 1 / computed
    for row in rows.values():
        rate = row["env_steps_per_second"]
        assert 0 < rate["low"] <= rate["median"] <= rate["high"]
        assert row["agent_steps_per_second"]["median"] == pytest.approx(3 * rate["median"])
        assert row["evaluations_per_second"] is None, "no episode was played to its end"
        assert set(row["ratios"]) == {"numba-all", "numba-one", "python"} - {row["name"]}
    assert len(set(rows["python"]["walls"])) == 1
    table = [line for line in out.splitlines() if line.startswith("|")]
    assert len(table) == 2 + len(rows)
    assert "× plain Python" in table[0]


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_picture_shows_every_factor_and_a_line_for_none(suffix, tmp_path):
    pytest.importorskip("matplotlib", reason="the extra plot is not installed")
    from benchmarks.plot import draw

    def row(value: int, rate: float) -> dict:
        return {"value": value, "env_steps_per_second": {"median": rate, "low": rate / 2, "high": rate * 2}}

    path = tmp_path / f"picture{suffix}"
    draw({"walls": [row(0, 9e4), row(8, 8e4), row(64, 4e4)], "batch": [row(1, 3e3)]}, path, "2 x cpu (cpu)")
    assert list(tmp_path.iterdir()) == [path]
    if suffix == ".svg":
        drawn = path.read_text()
        for label in ("walls", "no walls", "episodes at once", "env-steps per second"):
            assert f"<!-- {label} -->" in drawn


@pytest.mark.slow
def test_scaling_in_small(tmp_path):
    plotting = tmp_path / "plot"
    plotting.mkdir()
    picture = plotting / "scaling.png"
    figures_folder = tmp_path / "figures"
    figures_folder.mkdir()
    pytest.importorskip("matplotlib", reason="the extra plot is not installed")
    out, figures = run(
        "scaling", figures_folder, "--factors", "agents,devices", "--agents", "2,3", "--devices", "1",
        "--use", "1", "--base-batch", "16", "--steps", "20", "--repeats", "1", "--plot", str(picture),
    )  # fmt: skip
    found = {factor: [row["value"] for row in rows] for factor, rows in figures["tables"].items()}
    assert found == {"agents": [2, 3], "devices": [1]}
    for rows in figures["tables"].values():
        for row in rows:
            assert row["useful_share"] == 1
            assert row["bytes_per_slot"] > 1000
            assert row["microseconds_per_env_step"]["median"] > 0
    agents = [row["bytes_per_slot"] for row in figures["tables"]["agents"]]
    assert agents[0] < agents[1]
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert sum(line.startswith("|") for line in out.splitlines()) == 3 + 2 * 2


@pytest.mark.slow
def test_generation_in_small(tmp_path):
    out, figures = run(
        "generation", tmp_path, "--instances", "1,2", "--generations", "2", "--time-limit", "40", "--chunk", "20",
        "--fresh", "3", "--devices", "1", "--folder",
    )  # fmt: skip
    rows = figures["tables"]["open/short"]
    assert [row["instances"] for row in rows] == [1, 2]
    for row in rows:
        assert row["evaluations"] >= row["instances"] * (2 + 3)
        assert 0 < row["useful_share"] <= 1
        assert 0 <= row["host_share"] <= 1
        assert row["evaluations_per_second"] > 0
        assert row["peak_bytes"] > 10**7
    assert "bytes_per_run" in rows[1]
    assert sum(line.startswith("|") for line in out.splitlines()) == 2 + 2


# -- kernels -----------------------------------------------------------------------------------------------------------

PROGRAM = """
HloModule jit_advance

FileNames
1 "/somewhere/slcs2_jax/swarm/motion.py"
2 "/elsewhere/jax/numpy.py"

FunctionNames
1 "resolve"
2 "_where"
3 "one_step.<locals>.inner"

FileLocations
1 {file_name_id=1 function_name_id=1 line=1 end_line=1 column=1 end_column=2}
2 {file_name_id=2 function_name_id=2 line=3 end_line=3 column=1 end_column=2}
3 {file_name_id=1 function_name_id=3 line=3 end_line=3 column=1 end_column=2}

StackFrames
1 {file_location_id=1 parent_frame_id=1}
2 {file_location_id=2 parent_frame_id=1}
3 {file_location_id=2 parent_frame_id=3}
4 {file_location_id=3}

%body (p: f32[]) -> f32[] {
  %add_fusion.1 = f32[12]{0} fusion(%p), metadata={op_name="a" stack_frame_id=1}
  ROOT %select.2 = f32[12]{0} fusion(%p), metadata={op_name="b" stack_frame_id=2}
  %lost = f32[12]{0} copy(%p), metadata={op_name="c" stack_frame_id=3}
  %inner-1 = f32[12]{0} copy(%p), metadata={op_name="c" stack_frame_id=4}
}
"""


def test_kernels_are_put_down_to_the_innermost_function_of_the_package():
    assert kernels.origins(PROGRAM) == {
        "add_fusion.1": "swarm/motion.py resolve",
        "select.2": "swarm/motion.py resolve",
        "lost": "the compiler",
        "inner-1": "swarm/motion.py inner",
    }


@pytest.mark.slow
def test_kernels_in_small(tmp_path):
    _, saved = run("kernels", tmp_path, "--rows", "3")
    assert sum(row["share"] for row in saved["tables"]["open/short"]) == pytest.approx(1)


# -- environment -------------------------------------------------------------------------------------------------------


def test_random_actions_are_any_of_those_that_the_mask_allows_all_alike():
    mask = np.array([[True, False, True, True], [False, False, False, True]])
    keys = jax.random.split(jax.random.key(0), 3000)
    found = np.asarray(jax.vmap(environment.random_action, (0, None))(keys, mask))
    counts = np.stack([np.bincount(column, minlength=4) for column in found.T])
    assert (counts[~mask] == 0).all()
    assert (abs(counts[0, mask[0]] - 1000) < 120).all()


def test_every_size_does_about_as_much_work():
    sizes = [environment.steps_of(batch, 40_000) for batch in (1, 30, 256, 10**6)]
    assert sizes == [2000, 1334, 157, 10]


@pytest.mark.slow
def test_environment_steps_of_running_episodes_count_and_no_others(tmp_path):
    arena = make("open_short", {"swarm.agents": 2, "world.time_limit": 25})
    stretch = environment.Stretch(arena, 3, 20)  # which has played once
    assert [stretch.play().steps for _ in range(2)] == [3 * 5, 0]
    _, saved = run("environment", tmp_path, "--cells", "open/short", "--batch", "2,3", "--work", "40", "--repeats", "2")
    rows = saved["tables"]["open/short"]
    assert [(row["batch"], row["steps"]) for row in rows] == [(2, 20), (3, 14)]
    for row in rows:
        assert row["env_steps_per_second"]["median"] * 12 == pytest.approx(row["agent_steps_per_second"]["median"])
        assert row["compile_seconds"] > 0
