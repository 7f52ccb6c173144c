"""The calibration study: which points it tries, what it remembers, and the misfit by hand."""

import math

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.results.arm import CELLS, cell_named
from slcs2_jax.study.calibration import Estimate, Fit, Notebook, Point, fits, fits_table, points
from slcs2_jax.study.experiment import settings_with
from slcs2_jax.study.paper import tuning_means

LEVELS = {"radio.noise_dbm": [-97.0, -91.0], "swarm.agents": [8]}
JOINT = {"radio.path_loss_exponent": [2.6, 3.0], "swarm.agents": [8, 16]}


def test_the_defaults_each_level_alone_and_the_joint_search():
    found = points(LEVELS, JOINT, 4)
    assert [(point.kind, point.name) for point in found[:4]] == [
        ("default", "defaults"),
        ("level", "radio.noise_dbm=-97"),
        ("level", "radio.noise_dbm=-91"),
        ("level", "swarm.agents=8"),
    ]
    joint = [dict(point.values) for point in found[4:]]
    assert len(joint) == 4
    for values in joint:
        assert 2.6 <= values["radio.path_loss_exponent"] <= 3.0
        assert values["swarm.agents"] in range(8, 17)
        assert isinstance(values["swarm.agents"], int)
    # Sobol: each quarter of each setting once
    assert {int((values["radio.path_loss_exponent"] - 2.6) / 0.1001) for values in joint} == {0, 1, 2, 3}
    assert points(LEVELS, JOINT, 4) == found
    assert len(points(LEVELS, JOINT, 0)) == 4


def test_candidates_are_tried_as_they_stand():
    found = points({}, {}, 0, [{"swarm.speed": 4.0, "swarm.packets": 150}])
    assert [(point.kind, point.name) for point in found] == [
        ("default", "defaults"),
        ("candidate", "swarm.speed=4, swarm.packets=150"),
    ]


def test_points_are_settings():
    for point in points(LEVELS, JOINT, 8):
        settings = settings_with({}, dict(point.values))
        for name, value in point.values:
            section, attribute = name.split(".")
            assert getattr(getattr(settings, section), attribute) == value


@pytest.mark.parametrize(
    ("levels", "joint", "samples", "says"),
    [
        ({"radio.noise": [1.0]}, {}, 0, "radio.noise: no such setting"),
        ({}, {"swarm.agent": [1.0, 2.0]}, 0, "swarm.agent: no such setting"),
        ({}, JOINT, 3, "calibration.samples=3: accepted is 0 or a power of two"),
        ({}, {"swarm.speed": [2.0]}, 2, "calibration.joint.swarm.speed=.*a lower and an upper bound"),
        ({}, {"swarm.speed": [2.0, 1.0]}, 2, "a lower and an upper bound"),
    ],
)
def test_impossible_studies(levels, joint, samples, says):
    with pytest.raises(InputError, match=says):
        points(levels, joint, samples)


def test_the_notebook_remembers_by_cell_point_and_sizes(tmp_path):
    notebook, cell, sizes = Notebook(tmp_path / "notes"), CELLS[0], {"instances": 2}
    [default, *_] = tried = points(LEVELS, JOINT, 2)
    estimate = Estimate(designed=0.5, evolved=0.25)
    assert notebook.read(cell, sizes) == {}
    notebook.add(cell, default, estimate, sizes)
    notebook.add(cell, tried[-1], Estimate(designed=0.1, evolved=0.2), sizes)
    assert notebook.read(cell, sizes)[default.values] == estimate
    assert set(notebook.read(cell, sizes)) == {default.values, tried[-1].values}
    assert notebook.read(cell, {"instances": 3}) == {}
    assert notebook.read(CELLS[1], sizes) == {}
    file = tmp_path / "notes" / "open_short.jsonl"
    with file.open("a") as more:
        more.write('{"values": [')  # cut short: the process was killed
    assert len(notebook.read(cell, sizes)) == 2
    notebook.add(cell, tried[1], estimate, sizes)
    assert len(notebook.read(cell, sizes)) == 3


def test_a_damaged_notebook_is_refused_by_line(tmp_path):
    notebook = Notebook(tmp_path)
    for point in points(LEVELS, {}, 0)[:2]:
        notebook.add(CELLS[0], point, Estimate(designed=0.5, evolved=0.25), {"instances": 2})
    file = tmp_path / "open_short.jsonl"
    file.write_text(file.read_text().replace("-97.0", "-98.0"))
    with pytest.raises(InputError, match=r"open_short\.jsonl: line 2: its checksum does not fit.*delete that line"):
        notebook.read(CELLS[0], {"instances": 2})


def test_the_misfit_of_the_papers_own_figures_is_none():
    table = tuning_means()
    assert len(table) == 8
    # evolved: .594 over the short cells, .193 in long urban jammed
    exact = {cell: Estimate(designed=table[cell.name], evolved=0.594) for cell in CELLS}
    exact[cell_named("urban_jammed_long")] = Estimate(designed=table["urban_jammed_long"], evolved=0.193)
    [fit] = fits([Point("default", ())], {cell: {(): one} for cell, one in exact.items()})
    assert (fit.misfit, fit.misfit_designed, fit.misfit_evolved) == (
        pytest.approx(0),
        pytest.approx(0),
        pytest.approx(0),
    )


def test_the_misfit_is_the_root_mean_square():
    cells = {cell_named("open_short"): 0.565 - 0.3, cell_named("urban_jammed_long"): 0.684 + 0.4}
    estimates = {cell: {(): Estimate(designed=designed, evolved=0.193 + 0.1)} for cell, designed in cells.items()}
    [fit] = fits([Point("default", ())], estimates)
    assert fit.misfit_designed == pytest.approx(math.sqrt((0.3**2 + 0.4**2) / 2))
    assert fit.misfit_evolved == pytest.approx(0.1)  # of long urban jammed alone: no overall without all short cells
    assert fit.misfit == pytest.approx(math.sqrt((0.3**2 + 0.4**2 + 0.1**2) / 3))


def test_points_that_a_cell_lacks_are_left_out():
    default, other = Point("default", ()), Point("level", (("swarm.agents", 8),))
    full = {one.values: Estimate(designed=0.0, evolved=0.0) for one in (default, other)}
    found = fits([default, other], {CELLS[0]: full, CELLS[1]: {(): full[()]}})
    assert [fit.point for fit in found] == [default]


def test_the_table_puts_the_best_joint_point_first():
    def fit(kind, values, misfit):
        own = {CELLS[0]: Estimate(designed=0.1, evolved=0.2)}
        return Fit(point=Point(kind, values), estimates=own, misfit=misfit, misfit_designed=misfit, misfit_evolved=None)

    worse, better = fit("joint", (("swarm.agents", 9),), 0.5), fit("joint", (("swarm.agents", 10),), 0.4)
    level, default = fit("level", (("swarm.agents", 8),), 0.1), fit("default", (), 0.9)
    rows = fits_table([worse, level, better, default]).rows
    assert [row[1] for row in rows] == ["defaults", "swarm.agents=8", "swarm.agents=10", "swarm.agents=9"]
    assert rows[0][5:] == (0.1, 0.2, 0.1, 0.2)
