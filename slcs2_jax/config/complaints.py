"""Hydra's and OmegaConf's errors, several lines each, in this project's one line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.schema import unknown_setting

_NO_OPTION = re.compile(
    r"Could not find '(?P<group>[^']+)/(?P<option>[^'/]+)'"
    r".*?Available options in '[^']+':(?P<options>.*?)(\n\n|\nConfig search path|$)",
    re.S,
)
_NO_KEY = re.compile(r"Key '(?P<key>[^']+)' is not in struct\s+full_key: (?P<full>\S+)", re.S)
_NOT_OVERRIDABLE = re.compile(r"Could not (override|delete|append to config)[^']*'(?P<key>[^']+)'", re.S)
_AMBIGUOUS = re.compile(r"Ambiguous value for argument '(?P<override>[^']*)'", re.S)
_MISSING = re.compile(r"Missing mandatory value: (?P<key>\S+)")


def as_input_error(error: Exception, arguments: Sequence[str], groups: Mapping[str, Sequence[str]]) -> InputError:
    """The InputError that says in one line what the error says in several, naming the setting and what is accepted.

    `arguments` are the command line's, `groups` the groups of conf/ with their options.
    """
    text = str(error)
    cause = str(error.__cause__ or "")
    if found := _NO_OPTION.search(text):
        options = ", ".join(sorted(found["options"].split()))
        return InputError(f"{found['group']}={found['option']}: accepted is one of {options}")
    if found := _AMBIGUOUS.search(text):
        return InputError(f"{found['override']}: accepted is one value; add -m to run every combination of several")
    if found := _NO_KEY.search(text + "\n" + cause):
        return _unknown(found["full"], groups)
    if found := _MISSING.search(text):
        key = getattr(error, "full_key", None) or found["key"]
        return InputError(f"{key}: has no default; accepted is {key}=VALUE")
    if found := _NOT_OVERRIDABLE.search(text):
        key = found["key"].split("=")[0]
        return _unknown(key, groups) if "override" in found[1] else InputError(_one_line(text))
    if type(error).__name__ == "OverrideParseException":
        override = getattr(error, "override", "") or next((a for a in arguments if "=" not in a), "")
        return InputError(f"{override}: accepted is an override of the form setting=value ({_one_line(text)})")
    key = getattr(error, "full_key", None)
    return InputError(f"{key}: {_one_line(text)}" if key else _one_line(text))


def _unknown(key: str, groups: Mapping[str, Sequence[str]]) -> InputError:
    if key in groups:
        return InputError(f"{key}: accepted is {key}= one of {', '.join(groups[key])}")
    return unknown_setting(key)


def _one_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines()]
    lines = [
        line
        for line in lines
        if line and not line.startswith(("See https", "Set the environment", "full_key", "object_type"))
    ]
    return "; ".join(lines)[:400]
