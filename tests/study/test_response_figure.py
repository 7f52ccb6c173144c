"""Figures of a sweep: what they show, and by which measure."""

import pytest

pytest.importorskip("matplotlib")

from slcs2_jax.study.collect import collect
from slcs2_jax.study.experiment import reported_experiments
from slcs2_jax.study.response import grids, responses
from slcs2_jax.study.response_figure import grids_figure, responses_figure
from slcs2_jax.study.study import FRESH, studies


@pytest.fixture
def sweep(make):
    for speed in (2.0, 4.0):
        for exchange in (1, 5):
            for seed in range(3):
                own = {"swarm": {"speed": speed, "sharing_period": exchange}}
                level = speed / 10 + exchange / 20 + seed / 50
                type(make)(make.root / f"{speed}_{exchange}").evolved(
                    "slcs2", "open_short", seed, [level], fresh=level, **own
                )
    [found] = studies(collect(make.root), reported_experiments())
    return found


def test_responses(sweep):
    found = [one for one in responses(sweep, FRESH) if one.factor.name == "swarm.speed"]
    drawn = responses_figure(found)
    [panel] = [panel for panel in drawn.axes if panel.axison]
    assert list(panel.lines[0].get_xdata()) == [2.0, 4.0]
    assert panel.lines[0].get_ydata()[1] - panel.lines[0].get_ydata()[0] == pytest.approx(0.2)
    assert drawn.get_supxlabel() == "swarm.speed (m/step)"
    assert drawn.get_supylabel().startswith("winner's mean over fresh deployments")


def test_grids(sweep):
    found = grids(sweep, FRESH)
    drawn = grids_figure(found)
    panel = drawn.axes[0]
    assert [text.get_text() for text in panel.texts] == [
        f"{found[0].means[row, column]:.2f}" for row in found[0].rows.values for column in found[0].columns.values
    ]
    assert panel.get_title() == "SLCS2, short open (n = 3)"
    assert drawn.axes[-1].get_ylabel() == "mean of winner's mean over fresh deployments"
