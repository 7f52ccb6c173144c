"""The console command slcs2: finds the command, calls it, and turns errors into one line and an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from slcs2_jax.commands import find, listing
from slcs2_jax.config import invocation, plugins
from slcs2_jax.config.errors import InputError, StorageError
from slcs2_jax.config.escape import terminal

USAGE = f"""\
slcs2: evolve and evaluate the behaviour of swarms (SLCS2, arXiv 1910.12412)

{listing()}  slcs2 --version
  slcs2 COMMAND --help
  slcs2 --completion bash|zsh|fish    what a shell evaluates to complete all of this

Examples:
  slcs2 evolve environment=urban range=short seed=0 instances=8 generations=500 grammar=main
  slcs2 evolve -m environment=open,jammed,urban,urban_jammed range=short,long
  slcs2 evolve acceptance=ailta exchange=off radio.path_loss_exponent=3.0 run_dir=results/ablation
  slcs2 evaluate solution=RUN/solutions/instance_000_best.npz environment=urban range=long instances=30
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        return _dispatch(arguments)
    except InputError as error:
        return _fail(str(error), 2)
    except StorageError as error:
        return _fail(f"error: {error}", 1)
    except KeyboardInterrupt as error:  # one that was heeded says what was saved
        return _fail(str(error) or "interrupted; what was saved before is intact", getattr(error, "code", 130))
    except BrokenPipeError:  # whoever read our output went away
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:  # a file that the system does not let us look at
        return _fail(f"error: {error.filename or 'system'}: {error.strerror or error}", 1)


def _fail(message: str, code: int) -> int:
    line = terminal(" ".join(message.split()))
    print(f"slcs2: error: {line}" if code == 2 else f"slcs2: {line}", file=sys.stderr, flush=True)
    return code


def _dispatch(arguments: list[str]) -> int:
    if arguments and arguments[0] == "--version":
        from slcs2_jax import __version__

        print(f"slcs2 {__version__}")
        return 0
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        return _help(USAGE, settings=True)
    if arguments[0] in ("--completion", "--complete"):
        return _completion(arguments[0], arguments[1:])
    name, *rest = arguments
    command = find(name)
    plugins.load(plugins.named_in(rest))  # before settings are checked: they may name parts of the plug-ins
    if "-h" in rest or "--help" in rest:
        return _help(command.HELP, settings=command.TAKES_SETTINGS)
    if not command.TAKES_SETTINGS:
        rest = [argument for argument in rest if not argument.startswith(f"{plugins.SETTING}=")]
    invocation.begin(arguments)
    try:
        return command.run(rest)
    finally:
        invocation.end()


def _completion(option: str, words: list[str]) -> int:
    from slcs2_jax.commands.completion import candidates, script

    print(script(words) if option == "--completion" else "".join(f"{word}\n" for word in candidates(words)), end="")
    return 0


def _help(text: str, *, settings: bool) -> int:
    print(text)
    if settings:
        from slcs2_jax.config.table import settings_help

        print(settings_help(), end="", flush=True)
    return 0
