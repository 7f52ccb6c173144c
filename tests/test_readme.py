"""The README tells the truth: its commands and code run, its links lead somewhere, it is short."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from omegaconf import OmegaConf

from slcs2_jax import __version__
from slcs2_jax.config.registry import KINDS
from tests.documentation import README, ROOT, Block, blocks, follow

TEXT = README.read_text(encoding="utf-8")
BLOCKS = blocks(README)
SET_UP = [block for block in BLOCKS if block.text.startswith("bash scripts/")]  # run by .ci/run, as they stand
TO_RUN = [block for block in BLOCKS if block not in SET_UP]
MOST_WORDS = 1200


def name(block: Block) -> str:
    return re.sub(r"\W+", "-", block.text)[:40]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Where a reader would be."""
    return tmp_path_factory.mktemp("reader")


@pytest.mark.slow
@pytest.mark.parametrize("block", TO_RUN, ids=name)
def test_every_block_runs(block, folder, readers_cache):
    follow(block, folder, readers_cache)


def test_there_are_three_doors_and_each_can_be_tried():
    assert len(re.findall(r"^### ", TEXT, re.MULTILINE)) == 3
    assert [block.kind for block in TO_RUN] == ["bash", "python", "python"]
    assert all(block.runs and len(block.text.splitlines()) <= 12 for block in TO_RUN)


def test_it_is_short():
    assert len(TEXT.split()) <= MOST_WORDS


def test_the_set_up_commands_are_what_ci_runs():
    assert [block.text.strip() for block in SET_UP] == ["bash scripts/demo", "bash scripts/test"]
    lines = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    for block in SET_UP:
        assert block.text.strip() in lines
    assert [line for line in lines if line][-1] == "bash scripts/test"


def test_its_figures_are_those_of_the_documentation():
    speed = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    assert "467 000" in TEXT
    assert "1190 times" in TEXT
    assert "230 000, with AVX2 156 000), 4.5 times" in TEXT
    assert "| open short, 0 walls | 467 000 | 230 000 | 156 000 | 103 000 | 393 | 2.0 | 3.0 | 4.5 |" in speed
    assert f"{len(KINDS)} kinds of parts" in TEXT
    assert "killed 55 times" in TEXT
    reliability = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
    assert "55 times at random moments" in reliability


def test_links_within_the_repository_lead_somewhere():
    targets = [target for target in re.findall(r"\]\(([^)]+)\)", TEXT) if "://" not in target]
    assert targets
    assert [target for target in targets if not (ROOT / target).exists()] == []


def test_the_citation_is_of_this_version():
    said = OmegaConf.load(ROOT / "CITATION.cff")
    assert (said.version, said.license) == (__version__, "MIT")
    assert "1910.12412" in said.references[0].url
