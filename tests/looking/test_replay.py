"""slcs2 replay: animations and pictures of solutions and behaviours, and one line for any bad input."""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from slcs2_jax import cli
from slcs2_jax.config import InputError
from slcs2_jax.looking import animation
from slcs2_jax.looking.scene import FATES
from slcs2_jax.looking.solutions import animate, replay
from slcs2_jax.results import load_solution
from slcs2_jax.swarm.fate import Fate


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def colour(name: str) -> np.ndarray:
    return np.array([int(name[at : at + 2], 16) for at in (1, 3, 5)])


def frame(gif: Image.Image, number: int) -> np.ndarray:
    gif.seek(number)
    return np.array(gif.convert("RGB"))


def pixels_near(picture: np.ndarray, name: str) -> int:
    return int((np.abs(picture.astype(int) - colour(name)).max(axis=2) < 40).sum())


def test_a_run_becomes_an_animation(finished, tmp_path, capsys):
    assert cli.main(["replay", str(finished), "start=20", "end=60", "every=10", "fps=10"]) == 0
    shown = capsys.readouterr().out
    assert "evolved, open short, seed 0, the first 60 steps" in shown
    assert "replay replay.gif: 5 frames, 10 time-steps from one to the next" in shown
    with Image.open(tmp_path / "replay.gif") as gif:
        assert gif.n_frames == 5
        assert gif.size[0] == 900
        frames = [frame(gif, number) for number in range(5)]
    assert all((one != other).any() for one, other in itertools.pairwise(frames))


def test_steps_after_the_end_are_not_computed_and_those_before_are_the_episodes(finished):
    solution = load_solution(finished / "solutions" / "instance_000_best.npz")
    whole, told = replay(solution), []
    cut = replay(solution, steps=45, after_chunk=told.append)  # of whole sharing periods of ten steps
    assert (whole.ended, cut.ended, cut.steps, told) == (True, False, 50, [50])
    for name in ("x", "y", "holding", "waiting", "delivered"):
        np.testing.assert_array_equal(getattr(cut, name), getattr(whole, name)[:51], name)
    for name in ("action", "rule", "sent_to", "sent_fate", "heard"):
        np.testing.assert_array_equal(getattr(cut, name), getattr(whole, name)[:50], name)
    assert (cut.matched <= whole.matched).all()
    assert replay(solution, steps=10**6).ended


def test_a_notebook_draws_the_same_animation(finished, tmp_path, monkeypatch):
    assert cli.main(["replay", str(finished), "start=20", "end=60", "every=10", "fps=10", "out=by_command.gif"]) == 0
    recording = replay(load_solution(finished / "solutions" / "instance_000_best.npz"))
    assert animate(recording, "one.gif", start=20, end=60, every=10, fps=10).is_file()
    with Image.open("one.gif") as one, Image.open("by_command.gif") as other:
        assert one.n_frames == other.n_frames == 5
        assert (frame(one, 0) != frame(one, 4)).any()
    both = animate({"above": recording, "below": recording}, tmp_path / "two.gif", end=20, every=10)
    with Image.open(both) as two, Image.open("one.gif") as one:
        assert two.size[1] > 1.5 * one.size[1]
    for wrong, says in (
        ({"out": "a.txt"}, "out=a.txt: accepted is a file whose name ends in .gif or .mp4"),
        ({"end": 10**6}, "end=1000000: accepted is a whole number from 1 to"),
        ({"start": 60, "end": 60}, "start=60: accepted is a whole number from 0 to 59"),
        ({"fps": 0}, "fps=0: accepted is a whole number from 1 to 100"),
    ):
        with pytest.raises(InputError, match=re.escape(says)):
            animate(recording, **{"out": "b.gif", **wrong})
    with pytest.raises(InputError, match="recordings: none given"):
        animate({}, "b.gif")
    monkeypatch.setitem(sys.modules, "slcs2_jax.looking.animation", None)
    monkeypatch.delattr(sys.modules["slcs2_jax.looking"], "animation")
    with pytest.raises(InputError, match=r"accepted is an installation with slcs2_jax\[plot\]"):
        animate(recording, "b.gif")
    assert not (tmp_path / "b.gif").exists()


def test_two_behaviours_stand_one_above_the_other(finished, tmp_path, capsys):
    arguments = ["beside=designed", "environment=urban", "seed=5", "end=8", "every=4", "out=two.gif"]
    assert cli.main(["replay", str(finished), *arguments]) == 0
    shown = capsys.readouterr().out
    assert "evolved, urban short, seed 5, the first 10 steps" in shown
    assert "designed, urban short, seed 5, the first 10 steps" in shown
    with Image.open(tmp_path / "two.gif") as two:
        width, height = two.size
    assert height > width / 2


@pytest.mark.parametrize("picture", ["layout", "paths"])
@pytest.mark.parametrize("field", ["none", "power", "sinr"])
def test_pictures_of_a_span(finished, tmp_path, picture, field):
    out = tmp_path / "still.png"
    assert cli.main(["replay", str(finished), f"picture={picture}", f"field={field}", f"out={out}"]) == 0
    with Image.open(out) as image:
        drawn = np.array(image.convert("RGB"))
    assert (pixels_near(drawn, FATES[Fate.DELIVERED][0]) > 500) == (picture == "layout")


def test_a_picture_has_no_date_and_takes_vectors(finished, tmp_path):
    for name in ("a.svg", "b.svg"):
        assert cli.main(["replay", str(finished), "picture=paths", f"out={name}"]) == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_losses_have_their_own_colours(jammed_episode, tmp_path):
    one = jammed_episode
    steps = {
        fate: next((step for step in range(one.steps) if fate in {sent.fate for sent in one.transmissions(step)}), None)
        for fate in FATES
    }
    found = {fate: step for fate, step in steps.items() if step is not None}
    assert {Fate.DELIVERED, Fate.JAMMED} <= set(found)
    for fate, step in found.items():
        fates = {sent.fate for sent in one.transmissions(step)}
        animation.animate([one], ["x"], tmp_path / "x.gif", start=step, end=step + 1, every=1, fps=5)
        with Image.open(tmp_path / "x.gif") as gif:
            before, after = (frame(gif, number) for number in (0, 1))
        more = pixels_near(after, FATES[fate][0]) - pixels_near(before, FATES[fate][0])  # the legend has it, too
        assert more > 10, (fate, fates)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_it_becomes_a_video(finished, tmp_path):
    assert cli.main(["replay", str(finished), "end=50", "every=5", "out=a.mp4"]) == 0
    seen = subprocess.run(
        ["ffmpeg", "-v", "error", "-i", "a.mp4", "-f", "framemd5", "-"], capture_output=True, text=True, check=True
    )
    assert len([line for line in seen.stdout.splitlines() if not line.startswith("#")]) == 11


def test_a_run_under_way_says_so(under_way, capsys):
    assert cli.main(["replay", str(under_way), "picture=paths"]) == 0
    assert "has not ended: 4 of 4 generations; shown is what was saved last" in capsys.readouterr().err


def test_a_missing_encoder_is_named_before_anything_is_computed(finished, monkeypatch, capsys):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert cli.main(["replay", str(finished), "out=a.mp4"]) == 2
    line = capsys.readouterr().err
    assert "an .mp4 needs ffmpeg; accepted is a .gif, or an installation with ffmpeg or slcs2_jax[video]" in line
    assert line.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "accepted is slcs2 replay RUN, or policy=NAME"),
        (["nowhere"], "run=nowhere: holds no run"),
        (["RUN", "RUN"], "accepted is slcs2 replay RUN"),
        (["RUN", "member=99"], "member=99: accepted is best, or a number from 0"),
        (["RUN", "instance=2"], "instance=2: accepted is a whole number from 0 to 1"),
        (["RUN", "picture=film"], "picture=film: accepted is one of animation, layout, paths"),
        (["RUN", "field=noise"], "field=noise: accepted is one of none, power, sinr"),
        (["RUN", "beside=nobody"], "nobody"),
        (["RUN", "start=900"], "start=900 end="),
        (["RUN", "start=9", "end=9"], "accepted are 0 <= start < end <="),
        (["RUN", "every=0"], "every=0: accepted is a whole number from 1 on, or auto"),
        (["RUN", "fps=101"], "fps=101: accepted is a whole number from 1 to 100"),
        (["RUN", "deployment=1000001"], "deployment=1000001: accepted is"),
        (["RUN", "out=EXISTS"], "exists; accepted is a new file"),
        (["RUN", "out=a.avi"], "out=a.avi: accepted is a file whose name ends in .gif or .mp4 or .csv"),
        (
            ["RUN", "out=a.gif", "picture=paths"],
            ".png or .svg or .pdf or .csv or .parquet for picture=paths",
        ),
        (["RUN", "out=nowhere/a.gif"], "there is no folder nowhere"),
        (["RUN", "colour=red"], "colour"),
        (["RUN", "swarm.agents=9"], "swarm.agents=9: accepted is 3"),
        (["RUN", "-m"], "option=-m: accepted is --help"),
        (["RUN", "seed=1,2"], "seed"),
    ],
)
def test_bad_input_gets_one_line(arguments, says, finished, tmp_path, capsys):
    (tmp_path / "there.gif").write_text("mine")
    arguments = [one.replace("RUN", str(finished)).replace("EXISTS", "there.gif") for one in arguments]
    assert cli.main(["replay", *arguments]) == 2
    shown = capsys.readouterr()
    assert says in shown.err
    assert shown.err.count("\n") == 1
    assert (tmp_path / "there.gif").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["there.gif"]
