"""Completion of the command line in bash, zsh and fish: what a shell evaluates, and the words it then asks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from slcs2_jax.commands import COMMANDS, Command, find
from slcs2_jax.config import plugins
from slcs2_jax.config.conf import conf_dir, groups, options
from slcs2_jax.config.errors import InputError, refuse
from slcs2_jax.config.field import Described
from slcs2_jax.config.schema import settings_fields
from slcs2_jax.config.store import BY_VALUE

_OPTIONS = ("--help", "--version", "--completion")
_OF_SETTINGS = ("-m", "--cfg", "--config-dir", "--hydra-help", "--help")

_BASH = """\
_slcs2() {
  local line=${COMP_LINE:0:COMP_POINT} words word
  read -ra words <<<"$line"
  [[ $line == *[[:space:]] ]] && words+=("")
  word=${words[${#words[@]}-1]}
  mapfile -t COMPREPLY < <(slcs2 --complete "${words[@]:1}" 2>/dev/null)
  if [[ ${#COMPREPLY[@]} == 0 ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "${word#*=}")
  elif [[ $word == *=* && $COMP_WORDBREAKS == *=* ]]; then
    COMPREPLY=("${COMPREPLY[@]#*=}") # bash completes what follows the =
  fi
  [[ ${COMPREPLY[0]} == *= ]] && compopt -o nospace 2>/dev/null
  return 0
}
complete -F _slcs2 slcs2
"""
_ZSH = """\
_slcs2() {
  local -a found
  found=(${(f)"$(slcs2 --complete "${(@)words[2,CURRENT-1]}" "$PREFIX" 2>/dev/null)"})
  if (( $#found )); then
    compadd -S '' -- ${(M)found:#*=}
    compadd -- ${found:#*=}
  else
    compset -P '*='
    _files
  fi
}
compdef _slcs2 slcs2
"""
_FISH = """\
function __slcs2_complete
  set -l token (commandline -ct)
  set -l before (commandline -opc)
  set -l found (slcs2 --complete $before[2..-1] "$token" 2>/dev/null)
  if test (count $found) -gt 0
    printf '%s\\n' $found
  else if string match -q '*=*' -- "$token"
    set -l name (string replace -r '=.*' '' -- "$token")
    for path in (__fish_complete_path (string replace -r '^[^=]*=' '' -- "$token"))
      printf '%s=%s\\n' $name $path
    end
  else
    __fish_complete_path "$token"
  end
end
complete -c slcs2 -f -a '(__slcs2_complete)'
"""
SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}
USE = {
    "bash": 'eval "$(slcs2 --completion bash)" in ~/.bashrc',
    "zsh": 'eval "$(slcs2 --completion zsh)" in ~/.zshrc, after compinit',
    "fish": "slcs2 --completion fish | source, in ~/.config/fish/config.fish",
}


def script(arguments: Sequence[str]) -> str:
    """What a shell evaluates so that it completes slcs2. Raises InputError for a shell that is not known."""
    if len(arguments) != 1 or arguments[0] not in SCRIPTS:
        raise refuse("--completion", " ".join(arguments), "one of " + ", ".join(SCRIPTS))
    return SCRIPTS[arguments[0]]


def candidates(words: Sequence[str]) -> list[str]:
    """What the last of the words after `slcs2` may become; nothing where the shell should offer files.

    Never fails: plug-ins that cannot be loaded bring nothing.
    """
    *before, word = words or [""]
    if not before:
        return [one for one in (*COMMANDS, *_OPTIONS) if one.startswith(word)]
    name, *rest = before
    if name == "--completion":
        return [one for one in SCRIPTS if one.startswith(word)]
    try:
        command = find(name)
        plugins.load(plugins.named_in([*rest, word]))
    except InputError:
        return []
    setting, equals, _ = word.partition("=")
    offered = _values(setting, command) if equals else _names(name, command, rest)
    return sorted({one for one in offered if one.startswith(word)})


def _names(name: str, command: Command, rest: Sequence[str]) -> Iterator[str]:
    if name == "experiment" and not rest:
        yield from options(conf_dir() / "experiment")
        return
    yield from (f"{one}=" for one in (*command.OPTIONS, plugins.SETTING))
    if command.TAKES_SETTINGS:
        yield from (f"{field.name}=" for _, field in settings_fields())
        yield from (f"{group}=" for group in groups() if group != "experiment")
        yield from _OF_SETTINGS


def _values(name: str, command: Command) -> Iterator[str]:
    if name in groups():
        yield from (f"{name}={option}" for option in groups()[name])
    for _, field in settings_fields() if command.TAKES_SETTINGS else ():
        if name == field.name or BY_VALUE.get(name) == field.name:
            yield from (f"{name}={value}" for value in _values_of(field))


def _values_of(field: Described) -> Sequence[str]:
    return field.doc.names or (("true", "false") if field.kind is bool else ())
