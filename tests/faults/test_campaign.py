"""The campaign in small: kills at random moments, and damaged files. scripts/fault_campaign.py does it at length."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

import fault_campaign
import fault_campaign_damage
import fault_campaign_kills


@pytest.mark.slow
def test_killed_runs_end_with_the_same_bytes(tmp_path):
    figures = fault_campaign_kills.kills(9, tmp_path, seed=1, generations=40)
    assert sum(figures.kills.values()) == 9
    assert (figures.differing, figures.lost_generations, figures.tracebacks) == ([], 0, [])


def test_damaged_files_are_detected_or_harmless(tmp_path):
    figures = fault_campaign_damage.damage(150, tmp_path, seed=1)
    assert (figures.believed, figures.tracebacks) == ([], [])
    assert figures.detected >= 40


@pytest.mark.slow
def test_hostile_folders_are_refused_or_read_and_nothing_outside_is_touched(tmp_path):
    figures = fault_campaign._hostile(24, tmp_path, seed=7)
    assert figures["wrong"] == []
    assert figures["tried"] == 24 + 3 * 12
    assert figures["refused"] >= 4  # some two in five of the 24, by which they are


def test_the_campaign_says_so_when_something_is_wrong():
    right = {"kills": {"kills": {"evolve SIGKILL": 3}, "differing": []}, "damages": {"count": 2, "believed": []}}
    assert fault_campaign.clean(right)
    assert fault_campaign.report(right)[0].startswith("3 kills: 0 files differ")
    for part, name, value in (
        ("kills", "differing", ["a"]),
        ("kills", "lost_generations", 1),
        ("damages", "believed", ["b"]),
    ):
        assert not fault_campaign.clean(right | {part: right[part] | {name: value}})
    assert not fault_campaign.clean(right | {"inputs": {"passed": False}})
    hostile = {"tried": 3, "refused": 1, "read": 2, "slowest": 0.1, "largest": 2**21, "wrong": ["a"]}
    assert not fault_campaign.clean(right | {"hostile": hostile})
    assert fault_campaign.clean(right | {"hostile": hostile | {"wrong": []}})
    assert "1 refused, 2 read, at most 0.1 s and 2 MB" in fault_campaign.report(right | {"hostile": hostile})[-1]
