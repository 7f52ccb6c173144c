"""Memory is foreseen: an estimate near what was measured, and one line instead of a process that is killed."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import pytest

from slcs2_jax.config import Compute, InputError, Rules, Search, Settings, Swarm, World
from slcs2_jax.running import driver, memory

# Peaks per slot in kB (agents, rules, walls), measured as the growth of a process's resident memory on a CPU.
XLA = {(12, 100, 0): 105, (12, 100, 176): 174, (32, 100, 0): 770, (12, 400, 0): 441, (64, 100, 352): 3993}
NATIVE = {(12, 100, 0): 108, (12, 100, 176): 108, (32, 100, 0): 300, (12, 400, 0): 399, (64, 100, 352): 619,
          (2, 20, 0): 13, (64, 1000, 0): 4856}  # fmt: skip


def settings(agents: int = 12, rules: int = 100, *, walls: int = 0, **values) -> Settings:
    world = World.preset("urban") if walls else World()
    if walls:
        world = dataclasses.replace(world, building_spacing=6 * world.distance / walls)
    one = Settings(world=world, swarm=Swarm(agents=agents, clearance=0.5), rules=Rules(rules=rules))
    return dataclasses.replace(one, **values)


@pytest.mark.parametrize(
    ("native", "size", "measured"),
    [("off", *one) for one in XLA.items()] + [("on", *one) for one in NATIVE.items()],
)
def test_the_estimate_is_near_what_was_measured(native, size, measured):
    agents, rules, walls = size
    estimate = memory.slot_bytes(settings(agents, rules, walls=walls, compute=Compute(native=native))) / 1024
    assert 0.5 < estimate / measured < 2


def test_on_a_cpu_all_comes_from_the_same_memory(monkeypatch):
    monkeypatch.setattr(memory, "available_host", lambda: 10**9)
    one = settings(compute=Compute(native="off"))
    cpu = [SimpleNamespace(platform="cpu")]
    memory.check_memory(one, 4 * 10**8, 3000, cpu)
    with pytest.raises(InputError, match=r"memory: about 1\.2 GB would be needed and 1\.0 GB are free; .*slots \(now"):
        memory.check_memory(one, 4 * 10**8, 5000, cpu)
    with pytest.raises(InputError, match=r"lower the number of instances or runs, swarm.agents"):
        memory.check_memory(one, 9 * 10**8, 3000, cpu)


def test_a_gpu_has_memory_of_its_own(monkeypatch):
    def gpu(free: int) -> list[SimpleNamespace]:
        stats = {"bytes_limit": free + 10, "bytes_in_use": 10}
        return [SimpleNamespace(platform="gpu", memory_stats=lambda: stats)] * 2

    one = settings(compute=Compute(native="off"))
    monkeypatch.setattr(memory, "available_host", lambda: 10**6)
    memory.check_memory(one, 10**6, 10_000, gpu(10**9))
    with pytest.raises(InputError, match=r"device memory: about .* GB would be needed and 1.0 GB are free"):
        memory.check_memory(one, 10**6, 10_000, gpu(5 * 10**8))
    with pytest.raises(InputError, match=r"^memory: "):
        memory.check_memory(one, 2 * 10**6, 1, gpu(10**9))


def test_the_limit_of_a_container_counts(monkeypatch, tmp_path):
    monkeypatch.setattr(memory, "_CGROUP", tmp_path)
    free = memory.available_host()
    assert free is not None
    (tmp_path / "memory.max").write_text("max\n")
    (tmp_path / "memory.current").write_text("300\n")
    assert memory.available_host() == pytest.approx(free, rel=0.2)
    (tmp_path / "memory.max").write_text("1000\n")
    assert memory.available_host() == 700


@pytest.mark.parametrize(
    "values",
    [
        {"compute": Compute(slots=10**6)},
        {"instances": 10**5},
        {"instances": 10**5, "swarm": Swarm(agents=64, clearance=0.5)},
    ],
)
def test_what_cannot_fit_is_refused_before_anything_is_made(values, tmp_path):
    one = settings(run_dir=str(tmp_path / "run"), search=Search(generations=20), **values)
    with pytest.raises(InputError, match=r"memory: about .* lower "):
        driver.evolve([one])
    assert not (tmp_path / "run").exists()


def test_more_rows_than_can_be_read_back_are_refused(tmp_path):
    one = settings(run_dir=str(tmp_path / "run"), instances=1000, search=Search(generations=2001))
    with pytest.raises(InputError, match="generations=2001: accepted is at most 2000 with instances=1000"):
        driver.evolve([one])
    assert not (tmp_path / "run").exists()
    memory.check_rows(dataclasses.replace(one, run_dir=None))


def test_what_grows_with_a_setting_is_refused_with_what_would_fit(monkeypatch):
    monkeypatch.setattr(memory, "available_host", lambda: 10**9)
    memory.check_fits("frames", 1000, 10**6, "an animation")
    with pytest.raises(InputError, match=r"^frames=1001: an animation takes about .* accepted is at most 1000$"):
        memory.check_fits("frames", 1001, 10**6, "an animation")
