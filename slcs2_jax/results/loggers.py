"""Live logging: who is told of every generation while a run goes on (`logger=`). No result depends on it.

A logger is a class that is made with the settings of its run and has the methods of `Logger`; `register("logger", ...)`
takes one of a user's. A run that goes on after an interruption tells again of what was not saved.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import math
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from slcs2_jax.config.errors import InputError, show
from slcs2_jax.config.registry import KINDS
from slcs2_jax.config.schema import settings_to_dict
from slcs2_jax.config.settings import Settings
from slcs2_jax.results.files import append, make_folder

PROJECT = "slcs2_jax"
LOG, TENSORBOARD = "log.jsonl", "tensorboard"  # in the run folder
_PACKAGES = ("tensorboard", "wandb", "trackio")  # that a logger of their name needs; each is an extra
_IN_FOLDER = ("jsonl", "tensorboard")
_PLACE = ("instance", "seed", "generation")  # entries of a row that say whose it is


class Logger(Protocol):
    """What is told of a run."""

    def generation(self, row: Mapping[str, Any]) -> None:
        """A generation has ended: its row, as generations.jsonl has it."""
        ...

    def summary(self, summary: Mapping[str, Any]) -> None:
        """The run has ended: what summary.json says."""
        ...

    def close(self) -> None:
        """No more is coming in this process, whether the run has ended or not."""
        ...


def figures(row: Mapping[str, Any]) -> dict[str, float]:
    """The numbers in a row by name, `seed_003/fitness`, but for those that say whose row it is."""
    numbers = {name: float(value) for name, value in row.items() if isinstance(value, bool | int | float)}
    return {f"seed_{row['seed']:03d}/{name}": value for name, value in numbers.items() if name not in _PLACE}


class Nobody:
    """Tells nobody."""

    def __init__(self, settings: Settings) -> None: ...
    def generation(self, row: Mapping[str, Any]) -> None: ...
    def summary(self, summary: Mapping[str, Any]) -> None: ...
    def close(self) -> None: ...


class JsonLines:
    """Adds lines to log.jsonl in the run folder: each row with the time, s since 1970, and at last the summary."""

    def __init__(self, settings: Settings) -> None:
        self._file = Path(settings.run_dir or ".") / LOG

    def generation(self, row: Mapping[str, Any]) -> None:
        self._add({"time": round(time.time(), 3), **row})

    def summary(self, summary: Mapping[str, Any]) -> None:
        self._add({"time": round(time.time(), 3), "summary": summary})

    def close(self) -> None: ...

    def _add(self, line: Mapping[str, Any]) -> None:
        append(self._file, json.dumps(line).encode() + b"\n")


class TensorBoard:
    """Writes event files for TensorBoard below the run folder: `tensorboard --logdir FOLDER`."""

    def __init__(self, settings: Settings) -> None:
        from tensorboard.summary import Writer

        self._writer = Writer(str(_folder(settings, TENSORBOARD)))

    def generation(self, row: Mapping[str, Any]) -> None:
        for name, value in figures(row).items():
            self._writer.add_scalar(name, value, row["generation"])
        self._writer.flush()

    def summary(self, summary: Mapping[str, Any]) -> None:
        for one in summary["instances"]:
            self._writer.add_scalar(f"seed_{one['seed']:03d}/fresh_mean", one["fresh_mean"], one["generations"])

    def close(self) -> None:
        self._writer.close()


class WeightsAndBiases:
    """Tells Weights & Biases; WANDB_MODE=offline keeps it below the run folder until `wandb sync`."""

    def __init__(self, settings: Settings) -> None:
        import wandb

        if settings.run_dir is not None:
            _folder(settings, "wandb")  # which it makes itself, but would follow a link
        self._run = wandb.init(
            project=PROJECT,
            name=_name(settings),
            dir=settings.run_dir,
            config=settings_to_dict(settings),
            reinit="create_new",  # several runs go on side by side
            settings=wandb.Settings(silent=True),
        )

    def generation(self, row: Mapping[str, Any]) -> None:
        axis = f"seed_{row['seed']:03d}/generation"
        if row["generation"] == 0:
            self._run.define_metric(f"seed_{row['seed']:03d}/*", step_metric=axis)
        self._run.log({axis: row["generation"], **figures(row)})

    def summary(self, summary: Mapping[str, Any]) -> None:
        for one in summary["instances"]:
            self._run.summary[f"seed_{one['seed']:03d}/fresh_mean"] = one["fresh_mean"]

    def close(self) -> None:
        self._run.finish()


class Trackio:
    """Tells Trackio, which keeps it on this machine: `trackio show --project slcs2_jax`."""

    def __init__(self, settings: Settings) -> None:
        import trackio

        with contextlib.redirect_stdout(sys.stderr):  # it greets
            self._run = trackio.init(
                project=PROJECT, name=_name(settings), config=settings_to_dict(settings), resume="allow", embed=False
            )

    def generation(self, row: Mapping[str, Any]) -> None:
        self._run.log(figures(row), step=row["generation"])

    def summary(self, summary: Mapping[str, Any]) -> None:
        for one in summary["instances"]:
            self._run.log({f"seed_{one['seed']:03d}/fresh_mean": one["fresh_mean"]}, step=one["generations"])

    def close(self) -> None:
        with contextlib.redirect_stdout(sys.stderr):
            self._run.finish()


def _folder(settings: Settings, name: str) -> Path:
    """A folder in the run folder; made if it is not there. Raises StorageError, InputError if it leads elsewhere."""
    assert settings.run_dir is not None
    folder = Path(settings.run_dir) / name
    make_folder(folder, inside=Path(settings.run_dir))
    return folder


def _name(settings: Settings) -> str | None:
    return None if settings.run_dir is None else Path(settings.run_dir).name


def check_logger(settings: Settings) -> None:
    """Raise InputError unless there is such a logger, and what it needs."""
    name = settings.logger
    KINDS["logger"].get(name)
    if name in _PACKAGES and (sys.modules.get(name, name) is None or importlib.util.find_spec(name) is None):
        raise InputError(
            f"logger={name}: {name} is not installed; accepted is an installation with slcs2_jax[{name}], or none"
        )
    if name in _IN_FOLDER and settings.run_dir is None:
        raise InputError(f"logger={name}: writes into the run folder, and run_dir is null; accepted is a run_dir")


class Told:
    """The logger of a run; the first time that it fails it is let go with a note, and the run goes on."""

    def __init__(self, settings: Settings, note: Callable[[str], None] = lambda text: None) -> None:
        """Until it is started nobody is told."""
        self._settings, self._name, self._note = settings, settings.logger, note
        self._logger: Logger | None = None

    def start(self) -> None:
        """Make the logger. Raises InputError if that cannot be done."""
        make = KINDS["logger"].get(self._name)
        try:
            self._logger = make(self._settings)
        except Exception as error:
            raise InputError(
                f"logger={self._name}: did not start ({type(error).__name__}: {show(str(error))}); accepted is one "
                "that does, or none"
            ) from None

    def generation(self, row: Mapping[str, Any]) -> None:
        """See `Logger`; what is no finite number is left out."""
        finite = {name: value for name, value in row.items() if not (isinstance(value, float) and math.isnan(value))}
        self._tell(lambda logger: logger.generation(finite))

    def summary(self, summary: Mapping[str, Any]) -> None:
        """See `Logger`."""
        self._tell(lambda logger: logger.summary(summary))

    def close(self) -> None:
        """See `Logger`."""
        self._tell(lambda logger: logger.close())
        self._logger = None

    def _tell(self, what: Callable[[Logger], None]) -> None:
        if self._logger is None:
            return
        try:
            what(self._logger)
        except Exception as error:
            self._logger = None
            said = f"{type(error).__name__}: {show(str(error))}"
            self._note(f"logger={self._name} failed and is told no more ({said}); the run goes on")
