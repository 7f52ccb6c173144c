"""Figures: the same bytes from the same results, both forms, and what they show."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

pytest.importorskip("matplotlib")
import matplotlib

from slcs2_jax.looking import drawing
from slcs2_jax.results.arm import CELLS
from slcs2_jax.study import figure
from slcs2_jax.study.calibration import Estimate, fits, points
from slcs2_jax.study.collect import collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.study import BEST, studies


@pytest.fixture
def study(make):
    for number, cell in enumerate(("open_short", "urban_short", "urban_jammed_long")):
        for seed in range(3):
            make.evolved("slcs2", cell, seed, [0.1 * seed, 0.2 * seed + 0.1 * number])
            make.evolved("no_exchange", cell, seed, [-0.1 * seed, 0.1 * number])
    [one] = studies(collect(make.root), reported_experiments())
    return one


def test_files_are_the_same_again_whatever_style_is_set(study, tmp_path):
    first = drawing.save(lambda: figure.fitness_figure(study, BEST), tmp_path / "a")
    with matplotlib.rc_context({"axes.facecolor": "red", "font.size": 30, "svg.hashsalt": None}):
        second = drawing.save(lambda: figure.fitness_figure(study, BEST), tmp_path / "b")
        assert matplotlib.rcParams["font.size"] == 30  # and is put back
    assert [path.suffix for path in first] == [".png", ".svg"]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
    assert first[0].read_bytes().startswith(b"\x89PNG")
    ElementTree.parse(first[1])


def test_fitness_shows_means_intervals_and_the_papers_figures(study):
    drawn = figure.fitness_figure(study, BEST)
    short, long = drawn.axes
    assert [label.get_text() for label in short.get_xticklabels()] == [
        "open",
        "jammed",
        "urban",
        "urban jammed",
        "overall",
    ]
    assert short.get_ylabel() == "fitness"
    points = {line.get_label(): line for line in long.lines if not line.get_label().startswith("_")}
    assert points["SLCS2"].get_ydata()[0] == pytest.approx(0.4)
    assert points["printed in the paper"].get_ydata()[0] == 0.193
    # arms are told apart by marker and by how dark they are, not by hue alone
    markers = {name: (line.get_marker(), _lightness(line.get_color())) for name, line in points.items()}
    assert len({marker for marker, _ in markers.values()}) == len(markers)
    assert abs(markers["SLCS2"][1] - markers["no exchange"][1]) > 0.2


def _lightness(colour):
    return float(np.dot(matplotlib.colors.to_rgb(colour), (0.2126, 0.7152, 0.0722)))


def test_curves_are_means_by_generation_with_labelled_axes(study):
    drawn = figure.curves_figure(study)
    shown = [panel for panel in drawn.axes if panel.axison]
    assert [panel.get_title() for panel in shown] == [
        "short open (n = 3)",
        "short urban (n = 3)",
        "long urban jammed (n = 3)",
    ]
    line = next(line for line in shown[0].lines if line.get_label() == "SLCS2")
    np.testing.assert_allclose(line.get_xdata(), [1, 2])
    np.testing.assert_allclose(line.get_ydata(), [0.1, 0.2])
    assert drawn.get_supxlabel() == "generation"
    assert drawn.get_supylabel() == "best fitness of the search so far, mean and CI90"
    assert len(shown[0].collections) == 2  # a band for each arm


def test_curves_by_episodes_have_an_axis_for_each_world(study):
    drawn = figure.curves_figure(study, "episodes")
    shown = [panel for panel in drawn.axes if panel.axison]
    line = next(line for line in shown[0].lines if line.get_label() == "SLCS2")
    assert (line.get_xdata()[0], line.get_xdata()[-1]) == (2, 4)
    assert (line.get_ydata()[0], line.get_ydata()[-1]) == (pytest.approx(0.1), pytest.approx(0.2))
    assert drawn.get_supxlabel() == "episodes"
    assert not shown[0].get_shared_x_axes().joined(shown[0], shown[1])


def test_calibration_shows_every_level(tmp_path):
    tried = points({"radio.noise_dbm": [-97.0, -91.0], "swarm.agents": [8]}, {}, 0)
    estimates = {
        cell: {point.values: Estimate(designed=0.1 * at, evolved=0.2 * at) for at, point in enumerate(tried)}
        for cell in CELLS
    }
    drawn = figure.calibration_figure(fits(tried, estimates))
    assert [label.get_text() for label in drawn.axes[0].get_yticklabels()] == ["radio.noise_dbm", "swarm.agents"]
    assert [text.get_text() for text in drawn.axes[1].texts] == ["-97", "-91", "8"]
    assert all(panel.get_xlabel() for panel in drawn.axes)


def test_calibration_joins_labels_that_would_overlap_and_shows_the_joint_search():
    tried = points({"swarm.agents": [8, 10, 16]}, {"swarm.speed": [1.0, 3.0]}, 2)
    designed = dict(zip([point.values for point in tried], [0.0, 0.5, 0.3, 0.51, 1.0, -1.0], strict=True))
    estimates = {
        cell: {values: Estimate(designed=value, evolved=0.0) for values, value in designed.items()} for cell in CELLS
    }
    drawn = figure.calibration_figure(fits(tried, estimates))
    assert [label.get_text() for label in drawn.axes[0].get_yticklabels()] == ["swarm.agents", "joint search"]
    assert [text.get_text() for text in drawn.axes[1].texts] == ["10", "8, 16"]
    assert drawn.axes[1].texts[1].xy == (pytest.approx(0.505), 0)
    assert sorted(drawn.axes[1].lines[-1].get_xdata()) == [-1.0, 1.0]
