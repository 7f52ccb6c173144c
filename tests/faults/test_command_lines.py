"""Random command lines: one line that says what is accepted, or settings that the run can be made with.

SLCS2_INPUTS sets how many: each test tries a quarter of it.
"""

from __future__ import annotations

import contextlib
import io
import os
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from slcs2_jax import cli
from slcs2_jax.commands import COMMANDS, evolve
from slcs2_jax.config import Settings, settings_from, settings_to_dict
from slcs2_jax.config.conf import groups
from slcs2_jax.config.schema import settings_fields

INPUTS = int(os.environ.get("SLCS2_INPUTS", "200"))
some = settings(
    max_examples=max(10, INPUTS // 4), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

NAMES = st.one_of(
    st.sampled_from([field.name for _, field in settings_fields()]),
    st.sampled_from([*groups(), "radio", "swarm", "plugins", "solution", "policy", "rules.grammar", "hydra.mode"]),
    st.sampled_from(["hydra/launcher", "hydra/sweeper", "hydra.sweeper.params", "hydra.job.name", "hydra.searchpath"]),
    st.text(max_size=8),
)
PLAIN = st.one_of(
    st.integers().map(str),
    st.floats().map(str),
    st.sampled_from(["null", "true", "off", "open", "short", "main", "ailta", "none", "batched", "basic", "designed"]),
    st.sampled_from(["${seed}", "${nowhere}", "${hydra:job.num}", "${oc.env:HOME}", "???", "glob(*)", "range(1,3)"]),
    st.sampled_from(
        ["choice(1,2)", "interval(0,1)", "tag(a,b,1)", "sort(2,1)", "shuffle(1,2)", "int(1.5)", "json_str(1)"]
    ),
    st.text(max_size=6),
    st.text(alphabet="[]{}()=,:'\"\\$~+@*. \n\t\0#", max_size=8),
)
VALUES = st.one_of(
    PLAIN, st.lists(PLAIN, max_size=3).map(",".join), st.lists(PLAIN, max_size=3).map(lambda x: f"[{','.join(x)}]")
)
SIGNS = st.sampled_from(["", "", "", "", "+", "++", "~", "-", "--"])
ASSIGNMENTS = st.builds(lambda sign, name, value: f"{sign}{name}={value}", SIGNS, NAMES, VALUES)
OPTIONS = st.sampled_from(
    ["-m", "--multirun", "--cfg", "-c", "job", "--config-dir", "-cd", ".", "--package", "-i", "-h=1"]
)
ARGUMENTS = st.lists(st.one_of(ASSIGNMENTS, ASSIGNMENTS, ASSIGNMENTS, NAMES, OPTIONS, st.text(max_size=10)), max_size=4)
SETTINGS_COMMANDS = st.sampled_from(["evolve", "evolve", "evaluate", "experiment", "replay"])
OTHER_COMMANDS = st.sampled_from(
    [name for name in COMMANDS if name not in ("evolve", "evaluate", "experiment", "replay")]
)


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """What would have been computed: nothing is."""
    monkeypatch.chdir(tmp_path)
    found: list[Settings] = []

    def advance(runs, **_):
        found.extend(runs)
        return [SimpleNamespace(instances=[SimpleNamespace(best_fitness=0.0)]) for _ in runs]

    monkeypatch.setattr(evolve, "advance", advance)
    monkeypatch.setattr(
        "slcs2_jax.commands.experiment._run", lambda planned: found.extend(one.settings for one in planned)
    )
    monkeypatch.setattr("slcs2_jax.commands.experiment._conclude", lambda name, jobs: None)
    monkeypatch.setattr("slcs2_jax.study.calibrate.calibrate", lambda cells: None)
    monkeypatch.setattr("slcs2_jax.commands.evaluate._evaluate_job", lambda job, solution: 0.0)
    monkeypatch.setattr("slcs2_jax.commands.replay._show", lambda *_: None)
    monkeypatch.setattr("slcs2_jax.results.sweep.write_sweep", lambda *_: None)
    return found


def call(arguments: list[str]) -> tuple[int, str]:
    """The exit code, and what was said on stderr."""
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
        code = cli.main(arguments)
    return code, errors.getvalue()


def check(arguments: list[str], computed: list[Settings]) -> None:
    computed.clear()
    code, said = call(arguments)
    assert code in (0, 2), said
    if code == 2:
        lines = said.splitlines()
        assert len(lines) == 1, said
        assert lines[0].startswith("slcs2: error: ")
        assert len(lines[0]) < 1200
        assert computed == []
    for one in computed:
        assert settings_from(settings_to_dict(one)) == one


@some
@given(command=SETTINGS_COMMANDS, experiment=st.sampled_from([[], ["contributions"], ["calibration"]]), rest=ARGUMENTS)
@example(command="evolve", experiment=[], rest=["seed=\0"])
@example(command="evolve", experiment=[], rest=["-m", "seed=glob(*)"])
@example(command="evolve", experiment=[], rest=["environment=open", "environment=urban"])
@example(command="evolve", experiment=[], rest=["environment@world=open"])
@example(command="evolve", experiment=[], rest=["world={buildings: true}"])
@example(command="evolve", experiment=[], rest=["environment=choice(1,2)"])
@example(command="evaluate", experiment=[], rest=["solution=choice(1,2)"])
def test_any_command_line_is_refused_in_one_line_or_makes_settings(command, experiment, rest, computed):
    before = experiment if command == "experiment" else []
    check([command, *before, *rest], computed)


@some
@given(command=OTHER_COMMANDS, rest=ARGUMENTS)
def test_any_arguments_of_the_other_commands(command, rest, computed):
    code, said = call([command, *rest])
    assert code in (0, 2), said
    if code == 2:
        assert len(said.splitlines()) == 1, said


@some
@given(words=st.lists(st.one_of(st.sampled_from(list(COMMANDS)), NAMES, ASSIGNMENTS, st.text(max_size=5)), max_size=4))
def test_completion_never_fails(words):
    code, said = call(["--complete", *words])
    assert (code, said) == (0, "")
