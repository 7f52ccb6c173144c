"""Names from strangers come out as text."""

import csv
import io

import pytest

from slcs2_jax.config.escape import csv_cell, latex, markdown, markdown_code, terminal


def test_the_terminal_is_not_controlled():
    assert terminal("\x1b[2J\x07x\u202e\x9b\ud800") == "\\x1b[2J\\x07x\\u202e\\x9b\\ud800"
    assert terminal("a\nb\tc\r", lines=True) == "a\nb\tc\\r"
    assert terminal("plain ä ✓") == "plain ä ✓"


@pytest.mark.parametrize(
    ("text", "escaped"),
    [
        ("a|b", "a\\|b"),
        ("[l](javascript:x)", "[l\\](javascript:x)"),
        ("[l][m]", "[l\\][m]"),
        ("[l]: x", "[l\\]: x"),
        ("![p](x)", "\\![p\\](x)"),
        ("<script>", "\\<script>"),
        ("</td>", "\\</td>"),
        ("&#60;", "\\&#60;"),
        ("`x`", "\\`x\\`"),
        ("*x* _x_", "\\*x\\* \\_x\\_"),
        ("~~x~~", "\\~\\~x\\~\\~"),
        ("a\n# b", "a # b"),
        ("\x1b[2J", "\\x1b[2J".replace("\\", "\\\\")),
        ("open_short, [0.1, 0.2] > -1 & 5 < 6", "open_short, [0.1, 0.2] > -1 & 5 < 6"),
    ],
)
def test_markdown(text, escaped):
    assert markdown(text) == escaped


def test_code_holds_backticks():
    assert markdown_code("slcs2 evolve") == "`slcs2 evolve`"
    assert markdown_code("a ``b` c") == "```a ``b` c```"
    assert markdown_code("`") == "`` ` ``"
    assert markdown_code("a\n\n# b") == "`a # b`"


def test_latex():
    assert latex(r"\input{a}") == r"\textbackslash{}input\{a\}"
    assert latex("50 % & $x_1^2$ #~") == r"50 \% \& \$x\_1\textasciicircum{}2\$ \#\textasciitilde{}"
    assert latex("[1pt] x") == "{}[1pt] x"  # a row that begins so would be an argument of the row before
    assert latex("*x") == "{}*x"


@pytest.mark.parametrize("text", ["=1+1", "+1+1", "-1+1", "@SUM(1)", "\t=1", "\r=1", "\n=1", "-", "=cmd|' /C calc'!A0"])
def test_no_cell_is_a_formula(text):
    assert csv_cell(text) == f"'{text}"
    line = io.StringIO()
    csv.writer(line).writerow([csv_cell(text)])
    assert next(csv.reader(io.StringIO(line.getvalue(), newline=""))) == [f"'{text}"]


@pytest.mark.parametrize("text", ["-1", "+1.5e-3", "-.5", "a=1", "1-1", "", "'=1"])
def test_numbers_and_text_stay(text):
    assert csv_cell(text) == text
