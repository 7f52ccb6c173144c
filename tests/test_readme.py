"""The README tells the truth: its commands and code run, its table of values is current, its links lead somewhere."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from omegaconf import OmegaConf

from slcs2_jax import __version__
from slcs2_jax.config.table import settings_markdown
from slcs2_jax.looking.rulebook import rule_lines
from slcs2_jax.results import load_solution

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)

SET_UP = [block for _, block in BLOCKS if block.startswith("bash scripts/")]  # run by .ci/run, as they stand
TO_RUN = [(kind, block) for kind, block in BLOCKS if kind != "text" and block not in SET_UP]


def name(value: object) -> str:
    return re.sub(r"\W+", "-", str(value))[:40]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Where a reader would be: blocks run here one after the other and find what those before them left."""
    return tmp_path_factory.mktemp("reader")


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "block"), TO_RUN, ids=name)
def test_every_block_runs(kind, block, folder):
    commands = {"bash": ["bash", "-euo", "pipefail", "-c"], "python": [sys.executable, "-W", "error", "-c"]}
    kept = {variable: value for variable, value in os.environ.items() if not variable.startswith(("JAX_", "XLA_"))}
    path = f"{Path(sys.executable).parent}{os.pathsep}{kept['PATH']}"  # what activating does
    done = subprocess.run(
        [*commands[kind], block],
        cwd=folder,
        env=kept | {"PATH": path, "JAX_PLATFORMS": "cpu", "XDG_CACHE_HOME": str(folder / "cache")},
        capture_output=True,
        text=True,
        timeout=1800,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip(), "a command of the README that shows nothing"


def test_there_are_blocks_and_each_is_of_a_known_kind():
    assert {kind for kind, _ in BLOCKS} == {"bash", "python", "text"}
    assert [kind for kind, _ in TO_RUN].count("python") == 1


def test_the_set_up_commands_are_what_ci_runs():
    assert [block.strip() for block in SET_UP] == ["bash scripts/demo", "bash scripts/test"]
    lines = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    for block in SET_UP:
        assert block.strip() in lines
    assert [line for line in lines if line][-1] == "bash scripts/test"


def test_the_code_block_is_ten_lines():
    [code] = [block for kind, block in TO_RUN if kind == "python"]
    calls = [line for line in code.splitlines() if line and not line.startswith("import")]
    assert len(calls) <= 10


def test_the_table_of_values_is_current():
    shown = re.search(r"^<!-- settings: .*?-->\n(.*?)^<!-- end of settings -->$", README, re.MULTILINE | re.DOTALL)
    assert shown is not None
    assert shown[1] == settings_markdown(), "print it again with the command above the table"


def test_the_table_of_results_is_that_of_the_runs():
    shown = re.search(r"^<!-- results: .*?-->\n(.*?)^<!-- end of results -->$", README, re.MULTILINE | re.DOTALL)
    assert shown is not None
    figures = {}
    for experiment in ("contributions", "designed"):
        with (ROOT / "docs" / "results" / "paper" / f"{experiment}_fitness.csv").open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                figures[row["world"], row["arm"]] = float(row["fresh mean"]), float(row["best mean"])
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in shown[1].splitlines()[2:]]
    assert len(rows) == 10
    for world, *cells in rows:
        for arm, cell in zip(("SLCS2", "no novelty (AILTA)", "no exchange", "designed"), cells, strict=True):
            said = [float(number) for number in re.findall(r"[\d.-]+", cell.replace("−", "-"))]
            assert said == [round(number, 3) for number in figures[world, arm]][: len(said)], (world, arm)


def test_the_rules_in_words_are_those_of_the_solution_that_is_there():
    solution = load_solution(ROOT / "docs" / "results" / "paper" / "winner_long_urban_seed_003.npz")
    [block] = [block for kind, block in BLOCKS if kind == "text" and "most often" in block]
    shown = re.findall(r"^ *([\d.]+) +([\d.]+) +([\d.]+) +(\d+) +\d+ +\d+  (.*)  \[(.*)\]$", block, re.MULTILINE)
    lines = [line for line in rule_lines(solution) if line.agent == 7]
    assert len(shown) == 2
    for said, line in zip(shown, lines, strict=False):
        figures = f"{line.quality:.2f}", f"{line.strength:.4f}", f"{line.error:.2f}", str(line.usage)
        assert said == (*figures, line.rule, line.origin)


def test_links_within_the_repository_lead_somewhere():
    targets = [target for target in re.findall(r"\]\(([^)]+)\)", README) if "://" not in target]
    assert targets
    headings = re.findall(r"^#+ (.*)$", README, re.MULTILINE)
    anchors = {"#" + re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
    assert [target for target in targets if target not in anchors and not (ROOT / target).exists()] == []


def test_the_citation_is_of_this_version():
    said = OmegaConf.load(ROOT / "CITATION.cff")
    assert (said.version, said.license) == (__version__, "MIT")
    assert "1910.12412" in said.references[0].url


def test_scripts_that_are_named_exist():
    for script in set(re.findall(r"bash (scripts/\w+)", README)):
        assert (ROOT / script).is_file(), script


def test_every_field_of_a_row_is_explained():
    from dataclasses import fields

    from slcs2_jax.search import HistoryRow

    table = README[README.index("Fields of a row") :]
    for field in ("instance", "seed", *(field.name for field in fields(HistoryRow))):
        assert f"`{field}`" in table, field
