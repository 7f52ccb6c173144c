"""Assignments of the command line, checked before Hydra sees them: every slip is one line that names the setting."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from slcs2_jax.config.errors import InputError, refuse, show
from slcs2_jax.config.field import Described, accepted, check
from slcs2_jax.config.schema import accepted_paths, unknown_setting
from slcs2_jax.config.store import BY_VALUE, Primary
from slcs2_jax.config.world_text import by_path

Options = Callable[[str], Sequence[str]]

_PATHS = ("solution", "policy", "run_dir", "world.file")


class Checker:
    """What of the command line's assignments a command takes, and in which form Hydra must have it."""

    def __init__(self, primary: Primary, groups: Mapping[str, Sequence[str]], hydra_groups: Options) -> None:
        """`groups` are the groups of conf/ (and the user's) with their options, `hydra_groups` gives Hydra's own."""
        self._primary, self._groups, self._hydra_groups = primary, groups, hydra_groups
        self._fields: dict[str, tuple[str, Described]] = {}
        for path, section, field in primary.fields():
            names = {path, field.name, f"{section}.{field.attribute}" if section else path}
            self._fields |= dict.fromkeys(names, (path, field))

    def check(self, overrides: Sequence[str], *, sweep: bool) -> tuple[list[str], list[str]]:
        """The assignments as Hydra takes them, and the names that have several values; those only in a sweep.

        Raises InputError naming the first that is not accepted.
        """
        checked, swept = [], []
        for typed in overrides:
            text, key, several = self._checked(self._by_value(_quoted(by_path(typed))), typed)
            if several and not sweep:
                raise InputError(f"{show(typed)}: accepted is one value; add -m to run every combination of several")
            if several and not key.startswith("hydra"):
                swept.append(key)
            checked.append(text)
            if key == "world.file":
                checked.append("world.content=null")  # the text of a former file, if it held one
        return checked, swept

    def _by_value(self, text: str) -> str:
        """search=mine or grammar=a/file.bnf are no options of a group: they set what the options of the group set."""
        key, equals, value = text.partition("=")
        if key not in BY_VALUE or key not in self._groups or not equals:
            return text
        names = [name.strip() for name in value.split(",")]
        if all(name in self._groups[key] for name in names):
            return text
        if key == "grammar" and not any("/" in name or "\\" in name or "." in name for name in names):
            return text  # no path: a group's option that does not exist
        return f"{BY_VALUE[key]}={value}"

    def _checked(self, text: str, typed: str) -> tuple[str, str, bool]:
        """An assignment as Hydra takes it, the name it sets, and whether it has several values."""
        override = _parsed(text, typed)
        key = override.key_or_group
        if override.is_delete():
            raise InputError(f"{show(typed)}: accepted is setting=value; no setting can be taken away")
        if key.startswith("hydra."):
            return text, key, override.is_sweep_override()
        if key.split(".")[0] in self._primary.open:
            fills = isinstance(override.value(), dict)  # with names that are not there yet, too
            return f"++{text.lstrip('+')}" if fills else text, key, override.is_sweep_override()
        if key.startswith("hydra/"):
            _check_options(key, override, self._hydra_groups(key))
        elif key in self._groups:
            if override.is_force_add() or (override.is_add() and key in self._primary.groups()):
                raise InputError(f"{show(typed)}: accepted is {key}=OPTION, without the +")
            _check_options(key, override, self._groups[key])
        elif key in self._fields:
            if override.is_add():
                raise InputError(f"{show(typed)}: accepted is {key}=VALUE, without the +")
            text, key = self._setting(override, text)
        elif key not in self._primary.own:
            raise self._unknown(key)
        return text, key, override.is_sweep_override()

    def _setting(self, override: Any, text: str) -> tuple[str, str]:
        """An assignment to a setting under the name that the configuration has it, its values checked."""
        from hydra.core.override_parser.types import ValueType

        path, field = self._fields[override.key_or_group]
        value = text.partition("=")[2]
        if override.value_type is ValueType.GLOB_CHOICE_SWEEP:
            raise refuse(field.name, value, accepted(field))
        for given in _values(override):
            if isinstance(given, str) and "${" in given:
                continue  # known only when everything is composed, and checked then
            if (
                field.kind is str
                and type(given) in (int, float)
                and not (field.is_list or override.is_sweep_override())
            ):
                value = f"'{value}'"  # a text that looks like a number
            else:
                check(field, given)
        return f"{'++' if override.is_force_add() else ''}{path}={value}", path

    def _unknown(self, key: str) -> InputError:
        name = self._primary.name
        paths = accepted_paths()
        if key in self._primary.left_out or (key in paths and paths[key][0] in self._primary.left_out):
            return InputError(f"{show(key)}: no setting of slcs2 {name}; slcs2 {name} --help lists those that are")
        return unknown_setting(key)


def text_of(overrides: Sequence[str], name: str) -> str | None:
    """The text that a name is given, the last if it is given twice; None for none. Raises InputError for no text."""
    found = None
    for typed in overrides:
        if typed.partition("=")[0] == name:
            override = _parsed(_quoted(typed), typed)
            if override.is_sweep_override():
                raise refuse(name, typed.partition("=")[2], "one text")
            value = override.value()
            found = None if value is None else str(value)
    return found


def _parsed(text: str, typed: str) -> Any:
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException

    try:
        return OverridesParser.create().parse_override(text)
    except HydraException as error:
        reason = str(error.__cause__ or error).splitlines()[0]
        raise InputError(f"{show(typed)}: accepted is an override of the form setting=value ({show(reason)})") from None


def _values(override: Any) -> list[Any]:
    """The values that are known before anything is composed; of a range, an interval or a glob none."""
    from hydra.core.override_parser.types import ValueType

    if not override.is_sweep_override():
        return [override.value()]
    if override.value_type not in (ValueType.CHOICE_SWEEP, ValueType.SIMPLE_CHOICE_SWEEP):
        return []
    return [_unquoted(value) for value in override.sweep_iterator()]


def _unquoted(value: Any) -> Any:
    from hydra.core.override_parser.types import QuotedString

    if isinstance(value, list):
        return [_unquoted(entry) for entry in value]
    return value.text if isinstance(value, QuotedString) else value


def _check_options(key: str, override: Any, options: Sequence[str]) -> None:
    """Raise InputError unless every value is an option of the group."""
    accepts = "one of " + ", ".join(options) if options else f"a setting of it, such as those of {key}.*"
    for value in _values(override):
        if not isinstance(value, str):
            raise refuse(key, override.input_line.partition("=")[2], accepts)
        if value not in options and "${" not in value:
            raise refuse(key, value, accepts)


def _quoted(argument: str) -> str:
    """A path that holds what Hydra's grammar would read as syntax, in the quotes that keep it whole."""
    key, equals, value = argument.partition("=")
    plain = not set(value) & set("=(){}[]:;#&!~ '\"") or value[:1] in "'\"" or "${" in value
    if key not in _PATHS or not equals or plain:
        return argument
    # a backslash is itself, except before the quote that ends the text or stands in it
    escaped = re.sub(r"(\\*)(')", r"\1\1\\\2", value)
    escaped = re.sub(r"(\\+)$", r"\1\1", escaped)
    return f"{key}='{escaped}'"
