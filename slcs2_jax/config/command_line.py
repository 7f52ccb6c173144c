"""What stands on the command line of a command that takes settings: assignments, and the few options beside them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from slcs2_jax.config.errors import InputError, refuse

CFG_VALUES = ("job", "hydra", "all")
SWEEP = ("-m", "--multirun")
CFG = ("-c", "--cfg")
CONFIG_DIR = ("-cd", "--config-dir")
HYDRA_HELP = "--hydra-help"

_LAUNCHER_KEYS = ("hydra/launcher=", "hydra.launcher.", "+hydra.launcher.", "++hydra.launcher.")
_SWEEPER_KEYS = ("hydra/sweeper=", "hydra.sweeper.", "+hydra.sweeper.", "++hydra.sweeper.")


@dataclass(frozen=True)
class CommandLine:
    """Assignments as typed, and the options.

    Attributes:
        overrides: setting=value, as typed.
        sweep: -m: values may be several, and every combination is a job.
        show: of --cfg: print the composed configuration instead of doing anything; one of CFG_VALUES.
        config_dir: a folder with groups of the user's own.
        hydra_help: print what of Hydra is accepted.
    """

    overrides: tuple[str, ...]
    sweep: bool = False
    show: str | None = None
    config_dir: Path | None = None
    hydra_help: bool = False

    @classmethod
    def parse(cls, arguments: Sequence[str]) -> CommandLine:
        """Options may stand anywhere. Raises InputError naming an option that is not accepted."""
        line = cls(())
        rest = list(arguments)
        while rest:
            argument = rest.pop(0)
            if argument in SWEEP:
                line = dataclasses.replace(line, sweep=True)
            elif argument == HYDRA_HELP:
                line = dataclasses.replace(line, hydra_help=True)
            elif argument in (*CFG, *CONFIG_DIR):
                line = line._with_value(argument, rest.pop(0) if rest and not rest[0].startswith("-") else None)
            elif argument.startswith("-"):
                raise refuse("option", argument, "one of -m, --cfg job, --config-dir DIR, --hydra-help, --help")
            else:
                line = dataclasses.replace(line, overrides=(*line.overrides, argument))
        if line.show and line.sweep:
            raise InputError("option --cfg: not together with -m; accepted is one of the two")
        return line

    def _with_value(self, option: str, value: str | None) -> CommandLine:
        if value is None:
            raise InputError(f"option {option}: accepted is {option} VALUE")
        if option in CFG:
            if value not in CFG_VALUES:
                raise refuse(f"option {option}", value, "one of " + ", ".join(CFG_VALUES))
            return dataclasses.replace(self, show=value)
        if "\0" in value or not Path(value).is_dir():
            raise refuse(f"option {option}", value, "a folder that exists")
        return dataclasses.replace(self, config_dir=Path(value).resolve())

    def sets(self, key: str) -> bool:
        """Is there an assignment to this name?"""
        return any(override.startswith(f"{key}=") for override in self.overrides)

    @property
    def names_launcher(self) -> bool:
        """Is it said how jobs are launched, other than by this project's launcher?"""
        return any(a.startswith(_LAUNCHER_KEYS) and a != "hydra/launcher=batched" for a in self.overrides)

    @property
    def names_sweeper(self) -> bool:
        """Is another sweeper chosen than Hydra's basic one?"""
        return any(a.startswith(_SWEEPER_KEYS) for a in self.overrides)

    def without(self, *prefixes: str) -> CommandLine:
        """The same with assignments left out whose names begin so."""
        kept = tuple(a for a in self.overrides if not a.startswith(prefixes))
        return dataclasses.replace(self, overrides=kept)

    def without_launcher(self) -> CommandLine:
        """The same with every choice of a launcher, and of where it writes, left out."""
        return self.without(*_LAUNCHER_KEYS, "hydra.sweep.")
