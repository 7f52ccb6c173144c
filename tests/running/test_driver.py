"""Whole runs in small worlds: the folders they leave, and that neighbours in the batch change nothing."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

from slcs2_jax import cli, programs
from slcs2_jax.config import Compute, InputError, Learning, Radio, Rules, Search, Settings, Swarm, World
from slcs2_jax.policy.decision_list import load_decision_list
from slcs2_jax.results import FinishedRun, RunSummary, read_run
from slcs2_jax.running import driver
from slcs2_jax.running.batches import make_batches
from slcs2_jax.running.schedule import Batch

GENERATIONS, FRESH, RULES, AGENTS = 4, 5, 20, 4


def small(run_dir: Path | None = None, *, environment: str = "open", grammar: str = "main", **values) -> Settings:
    """A world that random rules can manage, and a short search."""
    search = {"generations": GENERATIONS, "fresh_deployments": FRESH} | values.pop("search", {})
    settings = Settings(
        world=dataclasses.replace(World.preset(environment), distance=190.0, time_limit=300),
        swarm=Swarm(agents=AGENTS, packets=4),
        rules=Rules(rules=RULES, grammar=grammar),
        search=Search(**search),
        compute=Compute(devices=1, chunk=50),
        instances=2,
        run_dir=None if run_dir is None else str(run_dir),
    )
    return dataclasses.replace(settings, **values)


class Watch:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.calls: list[dict] = []

    def generation(self, **values) -> None:
        self.calls.append({name: list(v) if isinstance(v, list) else v for name, v in values.items()})

    def note(self, text: str) -> None:
        pass


def rows(folder: Path) -> dict[int, list[dict]]:
    """The rows of each seed, in order of generation."""
    found: dict[int, list[dict]] = {}
    for row in read_run(folder).rows:
        found.setdefault(row["seed"], []).append({name: v for name, v in row.items() if name != "instance"})
    return found


def without_time(summary: RunSummary) -> tuple:
    return summary.instances


@pytest.fixture(scope="module")
def together(tmp_path_factory) -> tuple[Path, Watch, list[RunSummary]]:
    """Two instances each of the main and the channel grammar, and of the ablations, in one batch."""
    folder = tmp_path_factory.mktemp("together")
    watch = Watch()
    ablation = {"acceptance": "ailta", "exchange": False}
    settings = [
        small(folder / "main"),
        small(folder / "channel", grammar="channel"),
        small(folder / "ablation", search=ablation),
    ]
    return folder, watch, driver.evolve(settings, report=watch)


@pytest.fixture(scope="module")
def main_run(together) -> FinishedRun:
    return read_run(together[0] / "main")


# -- what a run leaves -------------------------------------------------------------------------------------------------


def test_every_instance_has_a_row_for_every_generation(main_run):
    by_seed = rows(main_run.path)
    assert by_seed.keys() == {0, 1}
    for own in by_seed.values():
        assert [row["generation"] for row in own] == list(range(GENERATIONS))
        assert [row["best"] for row in own] == list(np.maximum.accumulate([row["fitness"] for row in own]))
        assert own[0]["parent"] == -1
        assert own[0]["novelty"] is None
        assert all(row["novelty"] is not None and 0 <= row["novelty"] <= 1 for row in own[1:])
        assert all(row["deployments"] == (6 if row["fitness"] > 0 else row["deployments"]) for row in own)
        assert all(len(row["contribution"]) == AGENTS for row in own)


def test_something_is_delivered(main_run):
    assert any(row["delivered"] > 0 for row in main_run.rows)
    assert any(row["deployments"] == 6 for row in main_run.rows)


def test_the_summary_agrees_with_the_rows(together, main_run):
    assert main_run.summary is not None
    for instance, own in zip(main_run.summary["instances"], rows(main_run.path).values(), strict=True):
        assert instance["seed"] == own[0]["seed"]
        assert instance["best_fitness"] == own[-1]["best"]
        assert instance["evaluations"] == sum(row["deployments"] for row in own)
        assert instance["env_steps"] == round(sum(row["deployments"] * row["steps"] for row in own))
        assert -1 <= instance["fresh_mean"] <= 1
        assert instance["fresh_sd"] >= 0
    assert main_run.timing is not None
    assert main_run.timing["wall_seconds"] > main_run.timing["compile_seconds"] > 0
    assert 0 < main_run.timing["useful_share"] < 1
    [summary] = [one for one in together[2] if one.run_dir == str(main_run.path)]
    assert (main_run.summary, main_run.timing) == (summary.to_json(), summary.timing())


def test_the_best_solutions_are_saved_with_what_they_learnt(main_run):
    assert main_run.summary is not None
    for number, instance in enumerate(main_run.summary["instances"]):
        best = main_run.best(number)
        assert best.fitness == instance["best_fitness"]
        assert best.instance_seed == instance["seed"]
        assert best.rules.action.shape == (AGENTS, RULES)
        assert best.usage.any()
        assert best.quality[best.usage > 0].any()
        assert best.settings == dataclasses.replace(main_run.settings, run_dir=None, compute=Compute())
        assert (best.origin_generation <= best.generation).all()
        text = (main_run.path / "solutions" / f"instance_{number:03d}_best.txt").read_text()
        assert text.count("=>") == AGENTS * RULES
        assert 1 <= len(main_run.members(number)) == rows(main_run.path)[instance["seed"]][-1]["size"]


def test_progress_goes_up_to_the_end(together):
    _, watch, summaries = together
    last = watch.calls[-1]
    assert last["done"] == [GENERATIONS] * 6
    assert last["best"] == [i.best_fitness for summary in summaries for i in summary.instances]
    assert last["evaluations"] == sum(i.evaluations for summary in summaries for i in summary.instances)
    for name in ("evaluations", "env_steps"):
        values = [call[name] for call in watch.calls]
        assert values == sorted(values)
    for before, after in zip(watch.calls, watch.calls[1:], strict=False):
        assert all(new >= old for old, new in zip(before["done"], after["done"], strict=True))
        assert all(new >= old or math.isnan(old) for old, new in zip(before["best"], after["best"], strict=True))


def test_the_ablations_do_what_they_say(together):
    plain, ablation = rows(together[0] / "main"), rows(together[0] / "ablation")
    assert any(row["copied"] for own in plain.values() for row in own)
    assert not any(row["copied"] for own in ablation.values() for row in own)
    assert all(row["size"] == 1 for own in ablation.values() for row in own)
    # the first solution is random, and so the same under any search
    for seed in plain:
        assert plain[seed][0]["fitness"] == ablation[seed][0]["fitness"]


# -- neighbours --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("grammar", ["main", "channel"])
def test_a_run_alone_gives_the_rows_that_it_gives_beside_others(together, tmp_path, grammar):
    folder, _, summaries = together
    [alone] = driver.evolve([small(tmp_path / "alone", grammar=grammar)])
    assert rows(tmp_path / "alone") == rows(folder / grammar)
    [beside] = [one for one in summaries if one.run_dir.endswith(grammar)]
    assert without_time(alone) == without_time(beside)


def test_an_instance_alone_gives_the_rows_that_it_gives_among_others(together, tmp_path):
    driver.evolve([small(tmp_path / "one", seed=1, instances=1)])
    assert rows(tmp_path / "one") == {1: rows(together[0] / "main")[1]}


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    contents = []
    for attempt in ("first", "second"):
        driver.evolve([small(tmp_path / "run", seed=5)])
        (tmp_path / "run").rename(tmp_path / attempt)
        files = sorted(path for path in (tmp_path / attempt).rglob("*.*") if path.suffix in (".npz", ".txt", ".jsonl"))
        contents.append({path.name: path.read_bytes() for path in files})
    assert contents[0] == contents[1]
    assert len(contents[0]) >= 1 + 2 * 2 * 2


def test_another_seed_gives_another_run(together):
    by_seed = rows(together[0] / "main")
    assert [row["contribution"] for row in by_seed[0]] != [row["contribution"] for row in by_seed[1]]


@pytest.mark.slow
def test_walls_of_neighbours_change_nothing(tmp_path):
    everywhere = driver.evolve([small(tmp_path / "three", environment="urban", seed=3, instances=3)])
    alone = driver.evolve([small(tmp_path / "one", environment="urban", seed=4, instances=1)])
    assert rows(tmp_path / "one")[4] == rows(tmp_path / "three")[4]
    assert alone[0].instances[0] == everywhere[0].instances[1]


def test_runs_that_share_no_batch_come_back_in_order():
    settings = [
        small(instances=1, search={"generations": 1, "fresh_deployments": 1}, swarm=Swarm(agents=agents, packets=4))
        for agents in (3, 2, 3)
    ]
    settings = [dataclasses.replace(one, seed=seed) for seed, one in enumerate(settings)]
    summaries = driver.evolve(settings)
    assert [summary.instances[0].seed for summary in summaries] == [0, 1, 2]
    assert [summary.run_dir for summary in summaries] == [""] * 3


# -- evaluate ----------------------------------------------------------------------------------------------------------


def test_evaluating_the_winner_again_gives_its_fresh_mean(main_run, tmp_path, capfd):
    assert main_run.summary is not None
    for number, instance in enumerate(main_run.summary["instances"]):
        solution = main_run.path / "solutions" / f"instance_{number:03d}_best.npz"
        out = tmp_path / f"again_{number}"
        arguments = [f"seed={instance['seed']}", "instances=1", f"deployments={FRESH}", f"run_dir={out}"]
        compute = ["compute.devices=1", "compute.cache=false", "compute.chunk=50"]
        assert cli.main(["evaluate", f"solution={solution}", *arguments, *compute]) == 0
        again = json.loads((out / "summary.json").read_text())
        assert again["fitness_mean"] == instance["fresh_mean"]
        [scenario] = again["scenarios"]
        assert (scenario["fitness_sd"], scenario["deployments"]) == (instance["fresh_sd"], FRESH)
        assert f"{instance['fresh_mean']:.3f}" in capfd.readouterr().out


def test_evaluation_in_other_worlds(main_run):
    solution = main_run.best(0)
    settings = dataclasses.replace(main_run.settings, seed=50, instances=3, run_dir=None)
    summary = driver.evaluate(settings, solution, deployments=2)
    assert [one.seed for one in summary.scenarios] == [50, 51, 52]
    assert all(one.deployments == 2 and -1 <= one.fitness <= 1 for one in summary.scenarios)
    assert summary.mean == pytest.approx(np.mean([one.fitness for one in summary.scenarios]))


# -- refusals ----------------------------------------------------------------------------------------------------------


def test_a_folder_that_holds_a_run_stays_as_it_is(main_run):
    before = {path: path.read_bytes() for path in main_run.path.rglob("*") if path.is_file()}
    with pytest.raises(InputError, match=r"seed=1: run_dir=.* already holds a run with seed=0"):
        driver.evolve([small(main_run.path, seed=1)])
    assert {path: path.read_bytes() for path in main_run.path.rglob("*") if path.is_file()} == before


# -- a sweep over physical values --------------------------------------------------------------------------------------


@pytest.mark.parametrize("native", ["auto", "off"])
def test_points_that_differ_in_physical_values_come_to_what_each_comes_to_alone_and_compile_once(
    native,
):
    compute = Compute(devices=1, chunk=50, native=native)
    points = [
        small(radio=Radio(path_loss_exponent=exponent), swarm=Swarm(agents=AGENTS, packets=packets), compute=compute)
        for exponent, packets in ((2.7, 4), (2.9, 4), (2.7, 3))
    ]
    programs._programs.cache_clear()
    swept = driver.evolve(points)
    assert programs._programs.cache_info().misses == (native == "off")
    assert len({summary.instances for summary in swept}) == len(points)
    [alone] = driver.evolve([points[1]])
    assert alone.instances == swept[1].instances


POINTS: tuple[dict, ...] = (
    {},
    {"radio": Radio(path_loss_exponent=2.7, noise_dbm=-91.0, shadowing_db=6.0)},
    {"radio": Radio(power_dbm=23.0, wall_loss_db=4.0, sinr_threshold_db=6.0, half_power_db=-6.0)},
    {"swarm": Swarm(agents=AGENTS, packets=3, speed=2.0, clearance=1.0, tolerance=0.1)},
    {"learning": Learning(alpha_q=0.4, beta_q=0.5, alpha_grasp=0.5, trace_decay=0.6, initial_quality=1.0)},
    {"learning": Learning(alpha_q_final=0.01, cost_move=1.0, cost_communicate=0.5)},
)
APART: tuple[dict, ...] = (
    {"radio": Radio(fading="rayleigh")},
    {"radio": Radio(channels=(1, 6))},
    {"swarm": Swarm(agents=AGENTS + 1)},
    {"swarm": Swarm(agents=AGENTS, sharing_period=5)},
    {"swarm": Swarm(agents=AGENTS, failure_rate=0.01)},
    {"swarm": Swarm(agents=AGENTS, failures_at=(10,))},
    {"swarm": Swarm(agents=AGENTS, failure_rate=0.01, failure_keeps_packet=True)},
    {"learning": Learning(bp_max=10)},
    {"rules": Rules(rules=RULES + 1)},
)


def saved(folder: Path) -> dict[str, bytes]:
    """What a run comes to, file by file."""
    files = [folder / "generations.jsonl", folder / "summary.json", *folder.glob("solutions/*")]
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def test_points_with_values_of_their_own_share_a_batch_and_leave_the_bytes_of_each_alone(tmp_path, monkeypatch):
    shared: list[list[Batch]] = []

    def noted(*given, **named) -> list[Batch]:
        shared.append(make_batches(*given, **named))
        return shared[-1]

    monkeypatch.setattr(driver, "make_batches", noted)
    points = [small(tmp_path / f"together_{place}", environment="urban", **point) for place, point in enumerate(POINTS)]
    driver.evolve(points)
    [[batch]] = shared
    assert len(batch.tasks) == sum(point.instances for point in points)
    assert batch.rollout.native
    found = [saved(Path(point.run_dir)) for point in points]
    assert len({one["generations.jsonl"] for one in found}) == len(points)
    for place, point in enumerate(points):
        alone = dataclasses.replace(point, run_dir=str(tmp_path / f"alone_{place}"))
        driver.evolve([alone])
        assert saved(Path(alone.run_dir)) == found[place]


def test_only_sizes_and_parts_keep_runs_apart_where_the_native_chunk_computes():
    keys = [driver.batch_key(small(**point)) for point in POINTS]
    assert len(set(keys)) == 1
    assert len({*keys, *(driver.batch_key(small(**point)) for point in APART)}) == 1 + len(APART)
    off = Compute(devices=1, chunk=50, native="off")
    assert len({driver.batch_key(small(compute=off, **point)) for point in POINTS}) == len(POINTS)


def test_a_policy_is_deployed_in_each_run_with_its_own_values():
    runs = [small(**point) for point in POINTS]
    policy = load_decision_list("designed")
    together = driver.deploy_in_runs(runs, policy, deployments=2)
    for settings, found in zip(runs, together, strict=True):
        [alone] = driver.deploy_in_runs([settings], policy, deployments=2)
        assert [[one.fitness for one in each] for each in found] == [[one.fitness for one in each] for each in alone]
    assert len({found[0][0].fitness for found in together}) > 2
