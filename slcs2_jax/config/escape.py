"""Text from files, written so that whoever reads the output reads it as text: one function for each target's rules.

Names of folders, grammars and instances, recorded commands and the like may come from strangers. Nothing of them may
become markup, a formula of a spreadsheet, a LaTeX command or a control sequence of the terminal.
"""

from __future__ import annotations

import re

_LATEX = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\char34{}",
    "`": r"\textasciigrave{}",
    **{letter: f"\\{letter}" for letter in "&%$#_{}"},
}
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\Z", re.ASCII)
# What Markdown (CommonMark, GitHub's tables and strike-through) would read: emphasis, code, table cells, escapes; an
# underscore within a word, and a bracket that begins no link, are text already
_MARKDOWN = re.compile(
    r"[\\`*|]|~(?=~)|(?<=~)~|(?<![^\W_])_|_(?![^\W_])|\](?=[\[(:])|!(?=\[)|<(?=[A-Za-z/!?])|&(?=#?\w+;)"
)


def terminal(text: str, *, lines: bool = False) -> str:
    """Without control characters, line separators, direction marks and lone surrogates, which stand as \\x1b.

    lines: newlines and tabs may stay.
    """
    return text if text.isprintable() else "".join(map(_lines if lines else _printable, text))


def _printable(letter: str) -> str:
    return letter if letter.isprintable() else letter.encode("unicode_escape", "surrogatepass").decode("ascii")


def _lines(letter: str) -> str:
    return letter if letter in "\n\t" else _printable(letter)


def markdown(text: str) -> str:
    """As text of one line, in a table's cell too."""
    return _MARKDOWN.sub(lambda found: "\\" + found[0], terminal(" ".join(text.split())))


def markdown_code(text: str) -> str:
    """As code within a line: between more backticks than stand in it anywhere."""
    plain = terminal(" ".join(text.split()))
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", plain)), default=0))
    room = " " if plain.startswith("`") or plain.endswith("`") else ""
    return f"{fence}{room}{plain}{room}{fence}"


def latex(text: str) -> str:
    """As text, in a caption and a tabular's cell too, where a bracket or a star would belong to the rule before it."""
    plain = terminal(" ".join(text.split()))
    return "{}" * plain.startswith(("[", "*")) + "".join(_LATEX.get(letter, letter) for letter in plain)


def csv_cell(text: str) -> str:
    """With an apostrophe before what a spreadsheet would compute: = + - @, a tab or an end of line at the start.

    A number stays as it is. Commas, quotes and ends of lines are the CSV writer's task.
    """
    return f"'{text}" if text.startswith(_FORMULA) and not _NUMBER.match(text) else text
