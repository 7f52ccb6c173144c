"""Winners elsewhere: what each job comes to, that it is kept, and that nothing is computed twice."""

from __future__ import annotations

import dataclasses

import pytest

import slcs2_jax as slcs2
from slcs2_jax.config import InputError
from slcs2_jax.config.worlds import kinds_of
from slcs2_jax.running import transfer
from slcs2_jax.running.transfer import DEPLOYED, Traveller, deployed_in, travel
from tests.running.test_informed import settings

KINDS = kinds_of(["open/40..42", "urban/7"])


@pytest.fixture(scope="module")
def travellers(tmp_path_factory) -> list[Traveller]:
    folder = tmp_path_factory.mktemp("run")
    slcs2.evolve(settings(folder / "run", generations=5))
    run = slcs2.read_run(folder / "run")
    here = deployed_in(run.settings, slcs2.Compute(devices=1))
    made = [Traveller(policy=run.best(at), content=f"winner {at}", settings=here) for at in range(2)]
    made.append(Traveller(policy=run.best(0).forgetful(), content="winner 0 forgetful", settings=here))
    return [*made, Traveller(policy=slcs2.load_decision_list("designed"), content="designed", settings=here)]


def test_each_is_deployed_in_each_world(travellers, tmp_path):
    found = travel(travellers, KINDS, deployments=2, folder=tmp_path, report=None)
    assert [[len(own) for own in one] for one in found] == [[3, 1]] * 4
    for one, means in zip(travellers, found, strict=True):
        for kind, own in zip(KINDS, means, strict=True):
            for seed, mean in zip(kind.seeds, own, strict=True):
                here = dataclasses.replace(kind.settings(one.settings), seed=seed)
                assert slcs2.evaluate(here, one.policy, deployments=2).mean == pytest.approx(mean)


def test_what_is_there_is_not_computed_again(travellers, tmp_path, monkeypatch):
    at_once = travel(travellers, KINDS, deployments=1, folder=tmp_path, report=None)
    lines = (tmp_path / DEPLOYED).read_bytes().splitlines(keepends=True)
    assert len(lines) == 16
    # killed while it wrote the tenth
    (tmp_path / DEPLOYED).write_bytes(b"".join(lines[:9]) + lines[9][:20])
    calls = []
    evaluator = transfer.Evaluator.__call__

    def counted(self, policies, scenarios, **values):
        calls.append(len(policies) * len(scenarios))
        return evaluator(self, policies, scenarios, **values)

    monkeypatch.setattr(transfer.Evaluator, "__call__", counted)
    assert travel(travellers, KINDS, deployments=1, folder=tmp_path, report=None) == at_once
    assert sum(calls) == 7
    calls.clear()
    assert travel(travellers[::-1], KINDS[:1], deployments=1, folder=tmp_path, report=None)[3][0] == at_once[0][0]
    assert calls == []
    (tmp_path / DEPLOYED).write_bytes(b"".join([lines[0], b"x" + lines[1][1:], *lines[2:]]))
    with pytest.raises(
        InputError, match=r"deployments\.jsonl: line 2: .*; delete it, and everything is deployed again"
    ):
        travel(travellers, KINDS, deployments=1, folder=tmp_path, report=None)
