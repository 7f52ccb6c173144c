"""Kernels, copies and bytes of a GPU's program are counted from its text; the real one where it can be compiled."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import gpu_program
from benchmarks.gpu_counts import Counts, count, graphs

ROOT = Path(__file__).resolve().parent.parent

PROGRAM = """
HloModule jit_advance

%fused_add (p.0: f32[100], p.1: f32[100,8]) -> f32[100] {
  %p.0 = f32[100]{0} parameter(0)
  %p.1 = f32[100,8]{1,0} parameter(1)
  %row = f32[100,1]{1,0} slice(%p.1), slice={[0:100], [3:4]}
  %flat = f32[100]{0} bitcast(%row)
  ROOT %sum = f32[100]{0} add(%p.0, %flat)
}

%fused_update (q.0: f32[10,100], q.1: f32[100], q.2: s32[]) -> f32[10,100] {
  %q.0 = f32[10,100]{1,0} parameter(0)
  %q.1 = f32[100]{0} parameter(1)
  %new = f32[1,100]{1,0} bitcast(%q.1)
  %q.2 = s32[] parameter(2)
  %zero = s32[] constant(0)
  ROOT %put = f32[10,100]{1,0} dynamic-update-slice(%q.0, %new, %q.2, %zero)
}

%inner (c.1: (s32[], f32[100], f32[100,8], f32[10,100])) -> (s32[], f32[100], f32[100,8], f32[10,100]) {
  %c.1 = (s32[], f32[100]{0}, f32[100,8]{1,0}, f32[10,100]{1,0}) parameter(0)
  %i = s32[] get-tuple-element(%c.1), index=0
  %a = f32[100]{0} get-tuple-element(%c.1), index=1
  %b = f32[100,8]{1,0} get-tuple-element(%c.1), index=2
  %d = f32[10,100]{1,0} get-tuple-element(%c.1), index=3
  %add = f32[100]{0} fusion(%a, %b), kind=kLoop, calls=%fused_add, metadata={op_name="x(y)"}
  %put.1 = f32[10,100]{1,0} fusion(%d, %add, %i), kind=kLoop, calls=%fused_update
  %copy.1 = f32[100]{0} copy(%add)
  ROOT %t = (s32[], f32[100]{0}, f32[100,8]{1,0}, /*index=3*/f32[10,100]{1,0}) tuple(%i, %copy.1, %b, %put.1)
}

%test (c.2: (s32[], f32[100], f32[100,8], f32[10,100])) -> pred[] {
  %c.2 = (s32[], f32[100]{0}, f32[100,8]{1,0}, f32[10,100]{1,0}) parameter(0)
  ROOT %go = pred[] compare(%c.2, %c.2), direction=LT
}

ENTRY %main (m: (s32[], f32[100], f32[100,8], f32[10,100])) -> (s32[], f32[100], f32[100,8], f32[10,100]) {
  %m = (s32[], f32[100]{0}, f32[100,8]{1,0}, f32[10,100]{1,0}) parameter(0)
  ROOT %w = (s32[], f32[100]{0}, f32[100,8]{1,0}, f32[10,100]{1,0}) while(%m), condition=%test, body=%inner, KNOWN
}
"""
KNOWN = 'backend_config={"known_trip_count":{"n":"7"}}'
A_ROUND = Counts(
    kernels=3,
    copies=1,
    # the sum reads 100 numbers of each operand; the update reads 100 and the place, and writes 100; the copy copies 100
    bytes=4 * (3 * 100) + 4 * (2 * 100 + 1) + 4 * (2 * 100),
)


def test_a_loop_counts_as_often_as_it_goes_round():
    assert count(PROGRAM.replace("KNOWN", KNOWN)) == Counts().plus(A_ROUND, 7)


def test_the_host_waits_for_loops_of_unknown_length_and_for_branches():
    assert count(PROGRAM.replace(", KNOWN", "")) == Counts(3, 1, A_ROUND.bytes, waits=1)
    branching = PROGRAM.replace("copy(%add)", "conditional(%add)").replace("KNOWN", KNOWN)
    assert count(branching).waits == 7


GRAPHS = """\
000: kCommandBuffer [source | sink]
    001: kCopy [source | next=002 (1)] kCopy
    002: kWhile [prev=001 (1) | sink]
    condition:
        003: kCustomKernel [source | sink] compare
    body:
        004: kCustomKernel [source | sink] add
"""


@pytest.mark.parametrize(
    ("sequence", "expected"),
    [
        (GRAPHS, (1, 0)),
        (GRAPHS + "005: kCopy [source | sink] kCopy\n", (1, 1)),
        (GRAPHS.replace("000: kCommandBuffer", "000: kWhile"), (0, 3)),
        (GRAPHS + GRAPHS, (2, 0)),
    ],
)
def test_launches_outside_of_graphs(sequence, expected):
    assert graphs(sequence) == expected


def test_without_the_plugin_one_line_says_what_is_missing(capsys, monkeypatch):
    monkeypatch.setattr(gpu_program, "PLUGINS", ("no_such_plugin",))
    with pytest.raises(SystemExit) as ended:
        gpu_program.main([])
    assert ended.value.code == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "the extra gpu-tools" in err


@pytest.mark.slow
@pytest.mark.skipif(
    not any(map(importlib.util.find_spec, gpu_program.PLUGINS)), reason="the extra gpu-tools is not installed"
)
@pytest.mark.parametrize(
    ("cell", "batch", "kernels", "kilobytes"),
    [
        ("open/short", 240, 40, 90),
        ("urban/short", 240, 55, 110),
        ("open/short", 4096, 45, 85),
        ("urban/short", 4096, 55, 100),
    ],
)
def test_a_chunk_on_a_gpu_is_one_graph_of_few_kernels(cell, batch, kernels, kilobytes, tmp_path):
    path = tmp_path / "figures.json"
    command = [sys.executable, "-m", "benchmarks.gpu_program", "--cells", cell, "--batch", str(batch)]
    subprocess.run([*command, "--json", str(path)], cwd=ROOT, check=True, capture_output=True, timeout=900)
    [row] = json.loads(path.read_text())["tables"][cell]
    assert (row["graphs"], row["launches_outside_graphs"], row["waits"]) == (1, 0, 0)
    assert row["kernels_per_step"] <= kernels
    assert row["kilobytes_per_env_step"] <= kilobytes
