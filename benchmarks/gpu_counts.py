"""What a program compiled for a GPU consists of: kernels, copies and bytes per time-step, by its text."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

_SIZES = {"pred": 1, "s8": 1, "u8": 1, "s16": 2, "u16": 2, "f16": 2, "bf16": 2, "s32": 4, "u32": 4, "f32": 4,
          "s64": 8, "u64": 8, "f64": 8}  # fmt: skip
_ARRAY = re.compile(rf"\b({'|'.join(_SIZES)})\[([\d,]*)\]")
_COMPUTATION = re.compile(r"^(ENTRY )?%?([\w.-]+) \(.*\) -> .* \{$")
_OPERATION = re.compile(r"^ +(?:ROOT )?%?([\w.-]+) = (\(.*?\)|\S+) ([\w-]+)\((.*)$")
_NOTHING = {"parameter", "get-tuple-element", "tuple", "constant", "bitcast", "after-all"}  # no work at run time
_TRIPS = re.compile(r'"known_trip_count":\{"n":"(\d+)"')
_HOST = {"conditional", "infeed", "outfeed", "send", "recv"}  # the host takes part, or may


@dataclass(frozen=True)
class Operation:
    """A line of a program: its name, type as text, kind, and the rest of the line, operands first."""

    name: str
    type: str
    kind: str
    rest: str

    @property
    def operands(self) -> list[str]:
        """Names of the operands."""
        return re.findall(r"%([\w.-]+)", self.rest.partition(")")[0])

    def called(self, role: str) -> str:
        """The computation that this one calls, such as its body."""
        found = re.search(rf"\b{role}=%?([\w.-]+)", self.rest)
        assert found is not None
        return found[1]


@dataclass(frozen=True)
class Counts:
    """Of a program, each time that its parts run.

    Attributes:
        kernels: started, copies among them; not the tests of loops whose number of rounds is known.
        copies: kernels that do nothing but copy.
        bytes: operands read and results written by kernels, each once; of a slice and of an update in place, its own.
        waits: times that the host must look at something before it can go on.
    """

    kernels: int = 0
    copies: int = 0
    bytes: int = 0
    waits: int = 0

    def plus(self, other: Counts, times: int = 1) -> Counts:
        """These, and others so many times."""
        return Counts(*(a + times * b for a, b in zip(_values(self), _values(other), strict=True)))


def _values(counts: Counts) -> tuple[int, ...]:
    return dataclasses.astuple(counts)


def count(text: str) -> Counts:
    """Everything that an optimised HLO program (its text) does when it runs once."""
    computations, entry = _computations(text)
    return _count(entry, computations)


def _computations(text: str) -> tuple[dict[str, dict[str, Operation]], str]:
    """The operations of every computation, by name; and the name of the entry."""
    found: dict[str, dict[str, Operation]] = {}
    here: dict[str, Operation] = {}
    entry = ""
    for line in text.splitlines():
        if head := _COMPUTATION.match(line):
            here = found[head[2]] = {}
            entry = head[2] if head[1] else entry
        elif operation := _OPERATION.match(line):
            here[operation[1]] = Operation(*operation.groups())
    return found, entry


def _count(name: str, computations: Mapping[str, dict[str, Operation]]) -> Counts:
    operations = computations[name]
    total = Counts()
    for operation in operations.values():
        if operation.kind == "while":
            trips = _TRIPS.search(operation.rest)
            rounds = int(trips[1]) if trips else 1
            total = total.plus(_count(operation.called("body"), computations), rounds)
            total = total if trips else total.plus(Counts(waits=1))
        elif operation.kind == "call":
            total = total.plus(_count(operation.called("to_apply"), computations))
        elif operation.kind not in _NOTHING:
            moved = _moved(operation, operations, computations)
            total = total.plus(Counts(1, int(operation.kind == "copy"), moved, int(operation.kind in _HOST)))
    return total


def _moved(
    operation: Operation, operations: Mapping[str, Operation], computations: Mapping[str, dict[str, Operation]]
) -> int:
    """Bytes that a kernel reads and writes."""
    read = [_bytes(operations[name].type) if name in operations else 0 for name in operation.operands]
    written = _bytes(operation.type)
    if operation.kind == "fusion":
        fused = computations[operation.called("calls")]
        shares = _shares_read(fused)
        read = [round(size * shares.get(number, 0.0)) for number, size in enumerate(read)]
        for inner in fused.values():
            if inner.kind == "dynamic-update-slice":
                written += _bytes(fused[inner.operands[1]].type) - _bytes(inner.type)
    return sum(read) + written


def _shares_read(fused: Mapping[str, Operation]) -> dict[int, float]:
    """What share of each operand of a fused computation is read, by its number; too much rather than too little.

    Followed from the results back to the parameters: only slices need less than the whole, and an update in place needs
    nothing of what it updates.
    """
    needed = dict.fromkeys(fused, 0.0)
    needed[next(reversed(fused))] = 1.0  # the root is the last
    for name, operation in reversed(fused.items()):
        for number, operand in enumerate(operation.operands):
            if operand not in fused:
                continue
            share = needed[name]
            if operation.kind in ("broadcast", "concatenate", "pad", "gather"):
                share = 1.0
            elif operation.kind in ("slice", "dynamic-slice") and number == 0:
                share *= _bytes(operation.type) / max(1, _bytes(fused[operand].type))
            elif operation.kind == "dynamic-update-slice":
                share = 0.0 if number == 0 else 1.0
            needed[operand] = min(1.0, needed[operand] + share)
    parameters = (operation for operation in fused.values() if operation.kind == "parameter")
    return {int(one.rest.partition(")")[0]): needed[one.name] for one in parameters}


def _bytes(type_text: str) -> int:
    """Of an array or of a tuple of them."""
    return sum(
        _SIZES[kind] * math.prod(int(size) for size in sizes.split(",") if size)
        for kind, sizes in _ARRAY.findall(type_text)
    )


def graphs(sequence: str) -> tuple[int, int]:
    """Of the text of a sequence of launches: how many graphs it starts, and how many launches stand outside of any."""
    started = outside = 0
    depth: int | None = None  # of the graph that we are in
    for line in sequence.splitlines():
        launch = re.match(r"^( *)\d+: (k\w+)", line)
        if launch is None:
            continue
        indent = len(launch[1])
        if depth is not None and indent > depth:
            continue
        depth = None
        if launch[2] == "kCommandBuffer":
            started, depth = started + 1, indent
        elif launch[2] not in ("kWhile", "kSequential"):
            outside += 1
    return started, outside
