"""An episode as a table: who was where, did what by which rule, and sent a packet to whom with what fate."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

from slcs2_jax.config import InputError
from slcs2_jax.grammar.vocabulary import NO_ACTION, POWERS
from slcs2_jax.looking.recording import NOBODY, Recording
from slcs2_jax.results.files import write_whole

# Column, its type in Parquet, and what it says. A row for each agent at each moment, and one for each packet that the
# source sent in the step from that moment on.
COLUMNS = {
    "deployed": ("string", "what was deployed"),
    "step": ("int32", "moment, in time-steps since the episode began; actions and sends are of the step that follows"),
    "node": ("string", "number of the agent, or source"),
    "x": ("float32", "m, from the source"),
    "y": ("float32", "m, from the source"),
    "holds": ("bool", "holds a packet"),
    "down": ("bool", "has failed"),
    "action": ("string", "what it did, in words; empty for nothing"),
    "rule": ("int32", "number of the rule that was drawn, of the agent's own"),
    "condition": ("string", "that rule in words"),
    "sent_to": ("string", "node that a packet was sent to: number of an agent, source or sink"),
    "channel": ("int32", "number of the channel"),
    "power": ("string", "full or half"),
    "fate": ("string", "what became of the packet: delivered, weak, jammed, interference or refused"),
    "waiting": ("int32", "packets that wait at the source"),
    "delivered": ("int32", "packets that the sink has"),
}


def write_trace(path: Path, recordings: Sequence[Recording], titles: Sequence[str], *, start: int, end: int) -> int:
    """Write the moments from `start` to `end` of some episodes as CSV or Parquet; returns how many rows.

    Raises:
        InputError: Parquet without pyarrow.
        StorageError: the file cannot be written.
    """
    rows = [row for one, title in zip(recordings, titles, strict=True) for row in trace(one, title, start, end)]
    write = parquet_writer() if path.suffix == ".parquet" else _write_csv
    write_whole(path, lambda file: write(file, rows))
    return len(rows)


def trace(recording: Recording, title: str, start: int, end: int) -> list[tuple[Any, ...]]:
    """Rows in the order of COLUMNS of the moments from `start` to `end`, both included."""
    found: list[tuple[Any, ...]] = []
    n, rules = recording.agents, recording.rules
    conditions: dict[tuple[int, int], str] = {}
    for step in range(start, min(end, recording.steps) + 1):
        sends = recording.transmissions(step) if step < recording.steps else []
        by_sender = {one.sender: one for one in sends if one.sender < n}
        depot = int(recording.waiting[step]), int(recording.delivered[step])
        for agent in range(n):
            action, rule = None, None
            if step < recording.steps:
                number, drawn = int(recording.action[step, agent]), int(recording.rule[step, agent])
                action = None if number == NO_ACTION else recording.vocabulary.action_text(number)
                rule = None if drawn == NOBODY else drawn
            condition = None
            if rule is not None and rules is not None:
                condition = conditions.setdefault((agent, rule), rules.text(agent, rule))
            place = float(recording.x[step, agent]), float(recording.y[step, agent])
            state = bool(recording.holding[step, agent]), bool(recording.down[step, agent])
            sent = _sent(recording, by_sender.get(agent))
            found.append((title, step, str(agent), *place, *state, action, rule, condition, *sent, *depot))
        for one in sends:
            if one.sender == recording.source:
                nothing = (None,) * 5
                found.append((title, step, "source", 0.0, 0.0, *nothing, *_sent(recording, one), *depot))
    return found


def _sent(recording: Recording, one: Any) -> tuple[Any, Any, Any, Any]:
    """Receiver, channel, power and fate of a transmission; of none, nothing."""
    if one is None:
        return None, None, None, None
    names = {recording.source: "source", recording.sink: "sink"}
    channel = recording.vocabulary.channels[one.channel]
    return names.get(one.receiver, str(one.receiver)), channel, POWERS[one.power], one.fate.name.lower()


def _write_csv(file: BinaryIO, rows: Sequence[tuple[Any, ...]]) -> None:
    text = io.TextIOWrapper(file, "utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(rows)
    text.flush()
    text.detach()


def parquet_writer() -> Any:
    """What writes rows as Parquet. Raises InputError without pyarrow."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            "out: Parquet needs pyarrow, which is not installed; accepted is .csv, or an installation with "
            "slcs2_jax[data]"
        ) from None

    def write(file: BinaryIO, rows: Sequence[tuple[Any, ...]]) -> None:
        fields = [
            pyarrow.field(name, pyarrow.type_for_alias(kind), metadata={"meaning": meaning})
            for name, (kind, meaning) in COLUMNS.items()
        ]
        columns = [
            pyarrow.array(column, field.type) for column, field in zip(zip(*rows, strict=True), fields, strict=True)
        ]
        pyarrow.parquet.write_table(pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields)), file)

    return write
