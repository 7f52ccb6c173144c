"""Hydra underneath: compose configurations, one or many, from conf/ and overrides; its complaints become one line.

Nothing here knows what a run is: `run_hydra` hands every job's plain mapping to a function of the caller.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slcs2_jax.config.complaints import as_input_error
from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse
from slcs2_jax.config.world_text import by_path, with_world_text

Together = Callable[[list["Job"]], list[float]]

# Hydra's options that are passed on, and those that are followed by a value
FLAGS = frozenset({"-m", "--multirun", "--hydra-help"})
FLAGS_WITH_VALUE = frozenset({"-c", "--cfg", "-cd", "--config-dir"})
CFG_VALUES = ("job", "hydra", "all")

_LAUNCHER_KEYS = ("hydra/launcher=", "hydra.launcher.", "+hydra.launcher.", "++hydra.launcher.")
_SWEEPER_KEYS = ("hydra/sweeper=", "hydra.sweeper.", "+hydra.sweeper.", "++hydra.sweeper.")


@dataclass(frozen=True)
class Job:
    """One composed configuration.

    Attributes:
        config: nested mapping of plain values, everything resolved.
        overrides: what the command line set for this job, as typed.
        label: name of this job among those of a sweep, "" outside of one.
    """

    config: dict[str, Any]
    overrides: tuple[str, ...]
    label: str


def conf_dir() -> Path:
    """The folder conf/: inside the package when installed from a wheel, beside it in a checkout."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "conf", package.parent / "conf"):
        if (folder / "evolve.yaml").is_file():
            return folder
    raise InputError(f"conf={package / 'conf'}: not found; accepted is an installation with the project's conf folder")


def run_hydra(config_name: str, arguments: Sequence[str], together: Together) -> None:
    """Compose the configuration(s) that the arguments ask for and give them to `together`.

    Args:
        config_name: primary configuration in conf/, without suffix.
        arguments: overrides and Hydra's own options (-m for a sweep).
        together: runs jobs and returns a number for each (what an optimising sweeper would minimise). With the launcher
            of this project one call gets all the jobs of a sweep; with any other launcher one call gets one job.

    Raises:
        InputError: for whatever Hydra cannot compose.
    """
    from hydra import main as hydra_main
    from hydra.core.hydra_config import HydraConfig
    from hydra.types import RunMode

    arguments = [_quoted(_grammar_by_path(by_path(argument))) for argument in arguments]
    single: list[Job | Exception] = []
    own: list[BaseException] = []  # errors of `together`, as opposed to Hydra's

    with _complaints_in_one_line(arguments, own):
        swept = _checked_overrides(arguments)

        def run(jobs: list[Job]) -> list[float]:
            try:
                return together(jobs)
            except Exception as error:
                own.append(error)
                raise

        def task(config: Any) -> float:
            hydra = HydraConfig.get()
            if hydra.mode == RunMode.MULTIRUN:
                return run([make_job(config, hydra.overrides.task, swept)])[0]
            try:  # and run it below: Hydra writes a line of its own about any error inside a task
                single.append(make_job(config, hydra.overrides.task, None))
            except Exception as error:
                single.append(error)
            return 0.0

        def sweep(jobs: list[tuple[Any, Sequence[str]]]) -> list[float]:
            return run([make_job(config, overrides, swept) for config, overrides in jobs])

        task.together = sweep  # type: ignore[attr-defined]
        with tempfile.TemporaryDirectory(prefix="slcs2-") as scratch, _arguments_for_hydra(arguments, scratch):
            hydra_main(config_path=str(conf_dir()), config_name=config_name, version_base="1.3")(task)()
        for result in single:
            if isinstance(result, Exception):
                raise result
    if single:
        together([job for job in single if isinstance(job, Job)])


def groups() -> dict[str, list[str]]:
    """The groups of conf/ and their options."""
    return {
        folder.name: sorted(file.stem for file in folder.glob("*.yaml"))
        for folder in sorted(conf_dir().iterdir())
        if folder.is_dir()
    }


def is_sweep(arguments: Sequence[str]) -> bool:
    """Do the arguments ask for several jobs?"""
    return "-m" in arguments or "--multirun" in arguments


def names_launcher(arguments: Sequence[str]) -> bool:
    """Does the command line choose how jobs are launched, other than by this project's launcher?"""
    return any(a.startswith(_LAUNCHER_KEYS) and a != "hydra/launcher=batched" for a in arguments)


def names_sweeper(arguments: Sequence[str]) -> bool:
    """Does the command line choose another sweeper than Hydra's basic one?"""
    return any(a.startswith(_SWEEPER_KEYS) for a in arguments)


def without_launcher(arguments: Sequence[str]) -> list[str]:
    """The arguments with every choice of a launcher left out."""
    return [a for a in arguments if not a.startswith(_LAUNCHER_KEYS)]


def make_job(config: Any, overrides: Sequence[str], swept: Sequence[str] | None) -> Job:
    """A job from a composed configuration (without its hydra node); `swept` are the keys that differ among the jobs."""
    from omegaconf import OmegaConf

    plain = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
    assert isinstance(plain, dict)
    config = with_world_text({str(key): value for key, value in plain.items()})
    return Job(config, tuple(overrides), _label(overrides, swept))


def _label(overrides: Sequence[str], swept: Sequence[str] | None) -> str:
    """A folder name from the swept values: open_short, open_s3, ailta. No sweep: ""; a sweep of nothing: all."""
    if swept is None:
        return ""
    values = dict(override.lstrip("+").split("=", 1) for override in overrides if "=" in override)
    parts = []
    for key in swept:
        value = values.get(key, "").strip("'\"")
        if "grammar" in key:
            value = Path(value).stem
        short = "s" if key == "seed" else key.rsplit(".", 1)[-1] + "-"
        text = value if key in _SAY_VALUE_ALONE else short + value
        parts.append("".join(letter if letter.isalnum() or letter in "-._" else "-" for letter in text))
    return "_".join(parts) or "all"


_SAY_VALUE_ALONE = frozenset({"environment", "range", "grammar", "rules.grammar", "acceptance"})


def _grammar_by_path(argument: str) -> str:
    """grammar=some/file.bnf is no option of the group grammar: it sets the value that the options of the group set."""
    key, equals, value = argument.partition("=")
    is_path = any(mark in value for mark in ("/", ".", os.sep))
    return f"rules.grammar={value}" if key == "grammar" and equals and is_path else argument


def _overrides_of(arguments: Sequence[str]) -> list[str]:
    """The arguments that are neither options nor the values of options."""
    pairs = zip(["", *arguments], arguments, strict=False)
    return [a for before, a in pairs if not a.startswith("-") and before not in FLAGS_WITH_VALUE]


def _checked_overrides(arguments: Sequence[str]) -> list[str]:
    """The keys that are swept. Refuses what Hydra would take, or fail at, without a word about the setting."""
    from hydra.core.override_parser.overrides_parser import OverridesParser

    options = groups()
    swept = []
    for override in OverridesParser.create().parse_overrides(_overrides_of(arguments)):
        key = override.key_or_group
        if override.is_delete():
            raise InputError(f"{override.input_line}: accepted is setting=value; no setting can be taken away")
        if override.is_sweep_override():
            swept.append(key)
        elif key in options and not isinstance(override.value(), str):
            value = override.get_value_element_as_str()
            raise refuse(key, value, "one of " + ", ".join(options[key]))
    return [key for key in swept if not key.startswith("hydra")]


def _quoted(argument: str) -> str:
    """A path that holds what Hydra's grammar would read as syntax, in the quotes that keep it whole."""
    key, equals, value = argument.partition("=")
    plain = not set(value) & set("=(){}[]:;#&!~ '\"") or value[:1] in "'\"" or "${" in value
    if key not in ("solution", "run_dir", "world.file") or not equals or plain:
        return argument
    # a backslash is itself, except before the quote that ends the text or stands in it
    escaped = re.sub(r"(\\*)(')", r"\1\1\\\2", value)
    escaped = re.sub(r"(\\+)$", r"\1\1", escaped)
    return f"{key}='{escaped}'"


@contextmanager
def _arguments_for_hydra(arguments: Sequence[str], scratch: str) -> Iterator[None]:
    """Hydra reads sys.argv and, with HYDRA_FULL_ERROR=1, raises instead of printing; both are put back afterwards.

    What its sweeper writes (multirun.yaml, empty job folders) goes to a scratch folder unless the user names one.
    """
    extra = (
        []
        if any("hydra.sweep.dir=" in a for a in arguments)
        else [f"hydra.sweep.dir='{scratch}'", "hydra.sweep.subdir=."]
    )
    saved, full_error = sys.argv, os.environ.get("HYDRA_FULL_ERROR")
    options, overrides = _apart(arguments)
    sys.argv = [saved[0] if saved else "slcs2", *options, *overrides, *extra]
    os.environ["HYDRA_FULL_ERROR"] = "1"
    try:
        yield
    finally:
        sys.argv = saved
        if full_error is None:
            del os.environ["HYDRA_FULL_ERROR"]
        else:
            os.environ["HYDRA_FULL_ERROR"] = full_error


def _apart(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Options with their values, and overrides: argparse takes no overrides on both sides of an option."""
    options: list[str] = []
    overrides: list[str] = []
    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        if argument in FLAGS_WITH_VALUE:
            options += [argument, *rest[:1]]
            del rest[:1]
        else:
            (options if argument.startswith("-") else overrides).append(argument)
    return options, overrides


@contextmanager
def _complaints_in_one_line(arguments: Sequence[str], own: Sequence[BaseException]) -> Iterator[None]:
    """Whatever goes wrong in Hydra comes from the arguments; what the caller's function raised passes as it is."""
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException
    from yaml import YAMLError  # type: ignore[import-untyped]

    try:
        yield
    except InputError:
        raise
    except Exception as error:
        # a job of another launcher may have failed in another process: then the error is none that Hydra would raise
        elsewhere = is_sweep(arguments) and names_launcher(arguments)
        if error in own or (elsewhere and not isinstance(error, HydraException | OmegaConfBaseException | YAMLError)):
            raise
        raise as_input_error(error, arguments, groups()) from None
