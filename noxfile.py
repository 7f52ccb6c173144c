"""The tests on every Python that is at hand, and what a release needs: nox (extra dev), or nox -s tests-3.12.

Arguments after -- go to pytest: nox -s tests -- -m 'not slow'. Pythons that pyenv has are found, too.
"""

from __future__ import annotations

import os
import shutil
import subprocess

import nox

PYTHONS = ("3.11", "3.12", "3.13", "3.14")  # 3.14 where jaxlib has wheels for it

nox.options.sessions = ["tests"]
nox.options.error_on_missing_interpreters = False

if shutil.which("pyenv"):  # its commands answer for the versions that this names
    known = subprocess.run(["pyenv", "versions", "--bare"], capture_output=True, text=True, check=True).stdout.split()
    usable = [version for version in known if version.startswith(PYTHONS)]
    os.environ.setdefault("PYENV_VERSION", ":".join(usable or ["system"]))


def at_hand(version: str) -> bool:
    """Does this Python start? pyenv has a command for each that it knows of, also where that leads nowhere."""
    command = shutil.which(f"python{version}")
    return command is not None and subprocess.run([command, "-c", ""], capture_output=True).returncode == 0


@nox.session(python=[version for version in PYTHONS if at_hand(version)])
def tests(session: nox.Session) -> None:
    """The tests, with everything that they need; launchers and browsers apart."""
    session.install("--no-compile", ".[test,analysis,plot,data,rl]")
    session.run("python", "-m", "pytest", *session.posargs, env={"JAX_PLATFORMS": "cpu"})


@nox.session
def loggers(session: nox.Session) -> None:
    """Loggers with the packages that the other tests stand in for."""
    session.install("--no-compile", ".[test,tensorboard,wandb,trackio]")
    session.run("python", "-m", "pytest", "tests/results/test_loggers.py", *session.posargs)


@nox.session
def package(session: nox.Session) -> None:
    """Source distribution, wheel, and what they say of themselves; the citation."""
    session.install("build>=1.2,<2", "twine>=6,<7", "cffconvert>=2,<3")
    folder = session.create_tmp()
    session.run("python", "-m", "build", "--outdir", folder)
    session.run("twine", "check", "--strict", *(entry.path for entry in os.scandir(folder)))
    session.run("cffconvert", "--validate", "--infile", "CITATION.cff")
