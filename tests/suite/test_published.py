"""What the suite comes with: artefacts and results of its entries, and the table of them in the documentation."""

from __future__ import annotations

import base64
import json
import re
import zlib
from pathlib import Path
from typing import Any

import pytest

import slcs2_jax.suite
from slcs2_jax import cli
from slcs2_jax.config import Compute
from slcs2_jax.study.statistics import holm_of, wilcoxon
from slcs2_jax.suite.deployed import ready
from slcs2_jax.suite.entries import shipped
from slcs2_jax.suite.page import write_all
from slcs2_jax.suite.shown import best_of_fields
from slcs2_jax.suite.table import collect
from slcs2_jax.suite.training import made, plan, read_record
from slcs2_jax.suite.worlds import load_suite
from tests.documentation import ROOT

SHIPPED = Path(slcs2_jax.suite.__file__).parent / "v1"
SUITE = load_suite()
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def table():
    return collect(SUITE, [SHIPPED], list(SUITE.worlds.values()))


def index_of(page: str) -> dict[str, Any]:
    """What a page says beside its replays: the last block of its data."""
    text = re.findall(r'<script type="application/octet-stream;base64" id="data-\d+">([^<]*)</script>', page)[-1]
    return json.loads(zlib.decompress(base64.b64decode(text)))


def test_every_result_is_that_of_the_artefacts_beside_it(table):
    """Of as many trainings as it says, in all test worlds, as often as the suite wants."""
    assert table.results
    for (name, place), found in table.results.items():
        entry, world = shipped()[name], SUITE.worlds[place]
        seeds, trainings = world.seeds_of("test"), range(len(found.steps))
        assert found.steps.shape[1:] == (len(seeds), SUITE.deployments), (name, place)
        assert found.digest == ready(entry, world, seeds[0], [SHIPPED], trainings).digest, (name, place)


def test_no_training_spent_more_than_the_budget(table):
    """A search ends with the generation in which its episodes are spent, a network with the update."""
    for (name, place), found in table.results.items():
        entry, world = shipped()[name], SUITE.worlds[place]
        trainings = len(found.steps)
        planned = plan(entry, [world], SHIPPED, compute=Compute(), trainings=trainings) if entry.trained else []
        assert all(made(one) for one in planned), (name, place)
        said = [read_record(one.record) for one in planned]
        assert all(one["env_steps"] <= 1.05 * world.env_steps for one in said), (name, place)
        assert found.env_steps == sum(one["env_steps"] + one["validation_env_steps"] for one in said)
        assert found.episodes == sum(one["episodes"] + one["validation_episodes"] for one in said)


def test_the_documentation_has_the_table(table, tmp_path):
    folder = DOCS / "results" / "suite"
    made_again = {path.name: path.read_bytes() for path in write_all(tmp_path, table)}
    for name in set(made_again) - {"index.html"}:
        assert (folder / name).read_bytes() == made_again[name], f"slcs2 suite table out={folder} makes {name}"
    page, kept = (index_of(text.decode()) for text in (made_again["index.html"], (folder / "page.html").read_bytes()))
    assert len(kept.pop("replays")) == len(best_of_fields(table))
    assert page.pop("replays") == []
    assert kept == page
    [winners] = [part for part in made_again["table.md"].decode().split("\n\n") if part.startswith("| world | best |")]
    assert winners.strip() in (folder / "README.md").read_text(encoding="utf-8")


def test_the_documentation_tells_how_often_one_is_above_another(table):
    """Kinds in which the mean is greater, significantly, and significantly less: Wilcoxon's test in the same worlds."""
    told = " ".join((DOCS / "results" / "suite" / "README.md").read_text(encoding="utf-8").split())
    for first, second, above, better, worse, said in (
        (
            "informed",
            "designed",
            18,
            14,
            1,
            "above the designed behaviour in eighteen kinds, significantly in fourteen",
        ),
        ("informed", "slcs2", 18, 12, 0, "Above SLCS2 it is in eighteen, significantly in twelve, and nowhere"),
        ("ippo", "informed", 17, 13, 2, "above the informed search in seventeen kinds, significantly in thirteen"),
        ("slcs2", "random", 16, 12, 2, "above random search in sixteen kinds, significantly in twelve"),
    ):
        differences = [table.scores(first, world) - table.scores(second, world) for world in SUITE.worlds]
        shown = [p < 0.05 for p in holm_of([wilcoxon(one) for one in differences])]
        signs = [one.mean() > 0 for one in differences]
        counts = [sum(signs), sum(map(min, shown, signs)), sum(map(min, shown, [not sign for sign in signs]))]
        assert counts == [above, better, worse], (first, second)
        assert said in told


@pytest.mark.slow
def test_a_row_made_again_from_scratch_is_the_same_bytes(tmp_path, monkeypatch):
    """Alone and on one core; it was trained beside others."""
    monkeypatch.chdir(tmp_path)
    typed = ["informed", "trainings=1", "world=few", "run_dir=again", "compute.native=on", "compute.devices=1"]
    for action in ("train", "evaluate"):
        assert cli.main(["suite", action, *typed]) == 0
    place = "artefacts/informed/few/training_0"
    for file in (f"{place}.npz", f"{place}.json", "results/informed/few.npz"):
        assert Path("again", file).read_bytes() == (SHIPPED / file).read_bytes(), file
