"""Completion: the words that are offered, and the shells that are installed asking for them."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from slcs2_jax import cli
from slcs2_jax.commands.completion import SCRIPTS, candidates

ROOT = Path(cli.__file__).resolve().parent.parent


@pytest.mark.parametrize(
    ("words", "among", "not_among"),
    [
        (["ev"], {"evolve", "evaluate"}, {"resume"}),
        ([], {"evolve", "--help"}, set()),
        (["--completion", ""], {"bash", "zsh", "fish"}, set()),
        (["evolve", "radio.n"], {"radio.noise_dbm="}, {"radio.power_dbm=", "seed="}),
        (["evolve", "env"], {"environment="}, set()),
        (["evolve", "environment=u"], {"environment=urban", "environment=urban_jammed"}, {"environment=open"}),
        (["evolve", "search="], {"search=slcs2", "search=ailta", "search=random"}, set()),
        (["evolve", "exchange=t"], {"exchange=true"}, {"exchange=false"}),
        (["evaluate", "sol"], {"solution="}, set()),
        (["experiment", "con"], {"contributions"}, {"designed"}),
        (["experiment", "contributions", "arm"], {"arm="}, set()),
        (["resume", "FOLDER", "gen"], {"generations="}, set()),
        (["rules", "RUN", "so"], {"sort="}, {"solution="}),
        (["rules", "RUN", "p"], {"plugins="}, set()),
    ],
)
def test_words(words, among, not_among):
    found = set(candidates(words))
    assert among <= found
    assert not not_among & found


@pytest.mark.parametrize("words", [["dance", ""], ["evolve", "run_dir=r"], ["evolve", "plugins=[no!]", ""]])
def test_where_the_shell_should_offer_files_nothing_is_said(words):
    assert candidates(words) == []


def test_an_unknown_shell_is_one_line(capsys):
    assert cli.main(["--completion", "tcsh"]) == 2
    assert capsys.readouterr().err == "slcs2: error: --completion=tcsh: accepted is one of bash, zsh, fish\n"


# What each shell is asked, so that it asks slcs2: the line up to the cursor, words printed one a line.
ASK = {
    "bash": """
        eval "$(slcs2 --completion bash)"
        COMP_LINE={line} COMP_POINT=${{#COMP_LINE}}; COMP_POINT=${{#COMP_LINE}}
        _slcs2; printf '%s\\n' "${{COMPREPLY[@]}}" """,
    "fish": "slcs2 --completion fish | source; complete -C {line}",
    "zsh": """
        compdef() {{ :; }}; compset() {{ :; }}; _files() {{ print -r FILES; }}
        compadd() {{ while [[ $1 != -- ]]; do shift; done; shift; (( $# )) && print -rl -- "$@"; return 0; }}
        eval "$(slcs2 --completion zsh)"
        line={line}; words=("${{(@s: :)line}}"); CURRENT=$#words; PREFIX=$words[-1]
        _slcs2""",
}
INSTALLED = [shell for shell in SCRIPTS if shutil.which(shell)]


@pytest.fixture
def shell_says(tmp_path):
    """What a shell offers for a line, with a command slcs2 on its path."""
    command = tmp_path / "bin" / "slcs2"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m slcs2_jax "$@"\n')
    command.chmod(0o755)
    path = f"{command.parent}{os.pathsep}{os.environ['PATH']}"
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "result.npz").touch()

    def ask(shell: str, line: str) -> list[str]:
        done = subprocess.run(
            [shell, "-c", ASK[shell].format(line=shlex.quote(line))],
            cwd=tmp_path / "here",
            env=os.environ | {"PATH": path, "PYTHONPATH": str(ROOT), "HOME": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.stderr == ""
        return [word.split("\t")[0] for word in done.stdout.splitlines()]

    return ask


@pytest.mark.parametrize("shell", INSTALLED)
def test_shells_complete(shell, shell_says):
    assert shell_says(shell, "slcs2 resu") == ["resume"]
    assert shell_says(shell, "slcs2 evolve radio.noi") == ["radio.noise_dbm="]
    assert "seed=" in shell_says(shell, "slcs2 evolve ")
    values = ["jammed", "open", "urban", "urban_jammed"]
    said = values if shell == "bash" else [f"environment={value}" for value in values]
    assert shell_says(shell, "slcs2 evolve environment=") == said
    files = {"bash": ["result.npz"], "zsh": ["FILES"], "fish": ["solution=result.npz"]}
    assert shell_says(shell, "slcs2 evaluate solution=res") == files[shell]
