"""The page: what it says of runs, and that it needs nothing but itself. The next file looks at it in a browser."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import shutil
import zlib

import numpy as np
import pytest

from slcs2_jax import cli
from slcs2_jax.looking import page_data, page_replay
from slcs2_jax.looking.document import MARK
from slcs2_jax.looking.page import page
from slcs2_jax.looking.page_data import Shown, by_rank, history, lineage, rule_table
from slcs2_jax.looking.page_entries import chosen, entries
from slcs2_jax.looking.traffic import traffic
from slcs2_jax.results import read_run


def blocks(text: str) -> dict[str, bytes]:
    found = re.findall(r'<script type="application/octet-stream;base64" id="([^"]+)">([^<]*)</script>', text)
    return {name: zlib.decompress(base64.b64decode(data)) for name, data in found}


def index_of(text: str) -> dict:
    return json.loads(blocks(text)[re.search(r'data-index="([^"]+)"', text)[1]])


def unpacked(data: bytes) -> dict:
    """A replay as the page's own program reads it."""
    packed = zlib.decompress(data)
    size = int(np.frombuffer(packed, "<u4", 1)[0])
    found = json.loads(packed[4 : 4 + size])
    at = 4 + size
    for name, kind, length in found["sections"]:
        dtype = np.dtype(kind).newbyteorder("<")
        found[name] = np.frombuffer(packed, dtype, length, at)
        at += length * dtype.itemsize
    assert at == len(packed)
    return found


@pytest.fixture(params=["episode", "jammed_episode", "troubled_episode"])
def recorded(request):
    return request.getfixturevalue(request.param)


@pytest.mark.parametrize("frames", [page_replay.MOST_FRAMES, 12])
def test_a_replay_holds_the_episode(recorded, frames, monkeypatch):
    monkeypatch.setattr(page_replay, "MOST_FRAMES", frames)
    one, found = recorded, unpacked(page_replay.pack_replay(recorded))
    n, count, moments = one.agents, found["frames"], found["moments"]
    assert (found["agents"], found["steps"], found["fitness"]) == (n, one.steps, round(one.fitness, 5))
    assert (moments[0], moments[-1]) == (0, one.steps)
    assert count == len(moments) == (min(one.steps + 1, frames) if frames > 12 else count)
    assert count <= frames
    assert found["unit"] == page_replay.FINEST
    for name in ("x", "y"):
        places = np.cumsum(found[name].reshape(n, count), axis=1, dtype=np.int16) * found["unit"]
        np.testing.assert_allclose(places, getattr(one, name)[moments].T, atol=found["unit"] / 2 + 1e-4)
    np.testing.assert_array_equal(found["holding"].reshape(n, count), one.holding[moments].T)
    np.testing.assert_array_equal(found["down"].reshape(n, count), one.down[moments].T)
    jammers = len(one.scenario.jammers)
    assert found["reach"] == [round(one.reach(jammer), 2) for jammer in range(jammers)]
    for name in ("jammer_x", "jammer_y"):
        places = np.cumsum(found[name].reshape(jammers, count), axis=1, dtype=np.int16) * found["unit"]
        np.testing.assert_allclose(places, getattr(one, name)[moments].T, atol=found["unit"] / 2 + 1e-4)
    numbers = np.array([*one.vocabulary.channels, -1])
    np.testing.assert_array_equal(
        found["jammed"].reshape(jammers, count)[:, 1:], numbers[one.jammed[moments[1:] - 1].T]
    )
    np.testing.assert_array_equal(found["delivered"], one.delivered[moments])
    np.testing.assert_array_equal(found["rule"].reshape(n, count)[:, 1:], one.rule[moments[1:] - 1].T)
    np.testing.assert_array_equal(found["action"].reshape(n, count)[:, 1:], one.action[moments[1:] - 1].T)
    heard = found["heard"].reshape(count, -1)
    for frame in range(0, count, 3):
        bits = np.unpackbits(heard[frame], bitorder="little")[: (n + 2) * n].reshape(n + 2, n)
        np.testing.assert_array_equal(bits, one.neighbours(max(moments[frame] - 1, 0)))
    starts = found["starts"]
    assert starts[1] == 0
    for frame in range(1, count):
        counts = traffic(one, moments[frame - 1], moments[frame])
        for at in range(starts[frame], starts[frame + 1]):
            own = counts[found["sender"][at], found["receiver"][at]]
            assert own[found["fate"][at]] > 0
        assert starts[frame + 1] - starts[frame] == counts.any(axis=2).sum()


def test_a_long_replay_is_thinned():
    moments = page_replay.frame_moments(20_000, 12)
    assert len(moments) <= page_replay.MOST_FRAMES
    assert (moments[0], moments[-1]) == (0, 20_000)
    assert len(np.unique(np.diff(moments)[:-1])) == 1
    assert len(page_replay.frame_moments(40_000, 250)) * 250 <= page_replay.MOST_PLACES + 250
    assert page_replay.frame_moments(3, 12).tolist() == [0, 1, 2, 3]


def test_the_lineage_leads_from_the_winner_to_the_first(finished):
    run = read_run(finished)
    chain = lineage(Shown(run=run, instance=0, solution=run.best(0)))
    assert chain[0]["generation"] == run.best(0).generation
    assert chain[-1]["generation"] == 0
    assert all(one["kept"] + one["copied"] + one["fresh"] == 3 * 12 for one in chain)
    assert chain[-1]["kept"] == 0
    rows = [row for row in run.rows if row["instance"] == 0][:3]
    parents = [{**row, "parent": parent, "best_generation": 2} for row, parent in zip(rows, (-1, 0, 0), strict=True)]
    other = dataclasses.replace(run, rows=tuple(parents))
    assert [one["generation"] for one in lineage(Shown(run=other, instance=0))] == [2, 0]


def test_the_rules_stand_as_the_solution_has_them(finished, episode):
    solution = read_run(finished).best(0)
    table = rule_table(Shown(run=read_run(finished), instance=0, solution=solution, recording=episode))
    assert (table["agents"], table["rules"], len(table["text"])) == (3, 12, 36)
    assert table["texts"][table["text"][2 * 12 + 5]] == solution.rules.text(2, 5)
    np.testing.assert_allclose(table["quality"], solution.quality.ravel(), rtol=1e-4)
    assert table["matched"] == episode.matched.ravel().tolist()
    assert sum(table["chosen"]) == (episode.rule >= 0).sum()


def test_the_best_come_first_and_the_rest_has_its_course_alone(finished):
    run = read_run(finished)
    ranked = by_rank([run])
    fresh = [run.summary["instances"][instance]["fresh_mean"] for _, instance in ranked]
    assert fresh == sorted(fresh, reverse=True)
    first, second = entries(run, replayed=chosen([run], 1), deployment=1)
    assert (first.instance, first.deployment) == (ranked[0][1], 1)
    assert first.recording is not None
    assert second.recording is second.solution is None
    assert "slcs2 report RUN replays=2" in second.note
    assert history(second)["columns"]["generation"] == [0, 1, 2, 3]


def test_many_generations_are_thinned_but_no_best_is_lost(finished, monkeypatch):
    run = read_run(finished)
    monkeypatch.setattr(page_data, "MOST_ROWS", 2)
    drawn = history(Shown(run=run, instance=0))["columns"]
    best = {row["best_generation"] for row in run.rows if row["instance"] == 0}
    assert best <= set(drawn["generation"])


def test_the_page_needs_nothing_else_and_nothing_ends_its_data(finished, tmp_path):
    run = read_run(finished)
    text = page("</script><b>&", entries(run, replayed=chosen([run], 2), deployment=0))
    assert "<title>&lt;/script&gt;&lt;b&gt;&amp;</title>" in text
    assert index_of(text)["title"] == "</script><b>&"
    assert "@@" not in text
    known = r"www\.w3\.org/2000/svg|github\.com/leeoniya/uPlot \("  # a namespace, and a line in uPlot's head
    assert not re.search(rf"""(src|href)=["'](?!data:,)|url\((?!#)|@import|https?://(?!{known})""", text)
    assert len(index_of(text)["entries"]) == 2


def test_a_run_gets_its_page_and_an_earlier_one_is_replaced(finished, tmp_path, capsys):
    folder = tmp_path / "run"
    shutil.copytree(finished, folder)
    for _ in range(2):
        assert cli.main(["report", str(folder)]) == 0
    assert f"page {folder / 'report.html'}" in capsys.readouterr().out
    text = (folder / "report.html").read_text()
    facts = index_of(text)
    assert facts["entries"][0]["ended"]
    assert facts["entries"][0]["replay"] in blocks(text)


def test_a_solution_that_cannot_be_read_is_named(finished, tmp_path, capsys):
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    best = run / "solutions" / "instance_000_best.npz"
    best.unlink()
    best.symlink_to(finished / "solutions" / "instance_000_best.npz")
    assert cli.main(["report", str(run), "replays=1"]) == 0
    said = capsys.readouterr().err
    assert f"passed over: solution={best}: not a solution saved by slcs2 (is a link" in said
    assert cli.main(["report", str(run), "replays=1", "strict=on"]) == 3


def test_a_page_is_not_written_through_a_link(finished, tmp_path, capsys):
    run, mine = tmp_path / "run", tmp_path / "mine.html"
    shutil.copytree(finished, run)
    mine.write_text(MARK)
    (run / "report.html").symlink_to(mine)
    assert cli.main(["report", str(run), "replays=0"]) == 2
    assert "report.html: exists and is no page of a run" in capsys.readouterr().err
    assert mine.read_text() == MARK


def test_a_run_under_way_shows_what_there_is_and_says_so(under_way, capsys):
    assert cli.main(["report", str(under_way)]) == 0
    assert "has not ended: 4 of 4 generations" in capsys.readouterr().err
    first = index_of((under_way / "report.html").read_text())["entries"][0]
    assert not first["ended"]
    assert first["replay"] is not None
    (under_way / "checkpoint.npz").unlink()
    assert cli.main(["report", str(under_way)]) == 0
    first = index_of((under_way / "report.html").read_text())["entries"][0]
    assert "nothing was saved yet of instance" in first["note"]


def test_a_folder_of_runs_gets_a_page_beside_its_tables(finished, tmp_path, capsys):
    shutil.copytree(finished, tmp_path / "runs" / "one")
    assert cli.main(["report", str(tmp_path / "runs"), "replays=1"]) == 0
    assert f"page {tmp_path / 'runs' / 'report' / 'report.html'}" in capsys.readouterr().out
    report = tmp_path / "runs" / "report"
    index = index_of((report / "report.html").read_text())
    fresh = [one["fresh"] for one in index["runs"]]
    assert fresh == sorted(fresh, reverse=True)
    assert [(one["page"], one["replay"]) for one in index["runs"]] == [
        ("runs/one.html", True),
        ("runs/one.html", False),
    ]
    entries = index_of((report / "runs" / "one.html").read_text())["entries"]
    assert [one["replay"] is None for one in entries] == [False, True]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["RUN", "out=page.txt"], "out=page.txt: accepted is a file .html"),
        (["RUN", "out=nowhere/page.html"], "out=nowhere/page.html: accepted is a file .html in a folder that exists"),
        (["RUN", "out=there.html"], "out=there.html: exists and is no page of a run"),
        (["RUN", "generations=2"], "generations: not for a run"),
        (["RUN", "replays=x"], "replays=x: accepted is a whole number"),
        (["RUN", "deployment=1000001"], "deployment=1000001: accepted is"),
        (["RUN", "colour=red"], "setting=colour: accepted is one of replays, deployment, out, generations"),
        (["nowhere"], "folder=nowhere: no such folder"),
        ([], "report: 0 folders"),
    ],
)
def test_bad_input_gets_one_line(arguments, says, finished, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.html").write_text("mine")
    assert cli.main(["report", *(one.replace("RUN", str(finished)) for one in arguments)]) == 2
    line = capsys.readouterr().err
    assert says in line
    assert line.count("\n") == 1
    assert (tmp_path / "there.html").read_text() == "mine"
    assert not (finished / "report.html").exists()
