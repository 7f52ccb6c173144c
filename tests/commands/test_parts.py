"""slcs2 parts: every kind with its setting and its parts, and where users' come from."""

import subprocess
import sys
from pathlib import Path

import pytest

from slcs2_jax import cli
from slcs2_jax.config.registry import KINDS

ROOT = Path(cli.__file__).resolve().parent.parent


def test_every_kind_and_every_part_is_listed(capsys):
    assert cli.main(["parts"]) == 0
    shown = capsys.readouterr().out
    for kind, registry in KINDS.items():
        assert f"\n{kind}: {registry.meaning} ({registry.setting}=)\n" in "\n" + shown
        for name in registry.names():
            assert f"\n  {name} " in shown
    assert "  delivery  The paper's task: carry all packets to the sink, soon." in shown


def test_words_of_rules_are_listed_when_they_are_asked_for(capsys):
    assert cli.main(["parts", "clause"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("\n  ") == 97
    assert "\n  d_si < net\n" in shown
    assert cli.main(["parts", "move", "target"]) == 0
    assert "\n  jammer\n" in capsys.readouterr().out


def test_a_users_part_is_listed_with_the_module_it_comes_from(tmp_path, monkeypatch, capsys):
    (tmp_path / "slcs2_test_parts.py").write_text(
        "from slcs2_jax.config.registry import register\n"
        '@register("reward", "shy")\nclass Shy:\n    """Less the nearer the others are. And more."""\n'
    )
    monkeypatch.chdir(tmp_path)
    try:
        assert cli.main(["parts", "reward", "plugins=[slcs2_test_parts]"]) == 0
        shown = capsys.readouterr().out
        assert "  shy       Less the nearer the others are. And more.  [plug-in slcs2_test_parts]" in shown
    finally:
        KINDS["reward"].forget("shy")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(["wheel"], "parts: no kind 'wheel'; accepted is one of clause, action"), (["-m"], "option=-m"), (["a=b"], "a=b")],
)
def test_bad_input_is_one_line(arguments, says, capsys):
    assert cli.main(["parts", *arguments]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_it_starts_neither_jax_nor_hydra(tmp_path):
    code = "import sys, slcs2_jax.cli as c; c.main(['parts']); print([m for m in ('jax', 'hydra') if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env={"PYTHONPATH": str(ROOT)}, capture_output=True, text=True
    )
    assert done.stdout.endswith("[]\n"), done.stderr
