"""The table of an episode: it says what the recording says, in both forms."""

import csv

import pytest

from slcs2_jax import cli
from slcs2_jax.looking.recording import NOBODY
from slcs2_jax.looking.trace import COLUMNS, trace, write_trace


def test_the_table_holds_the_episode(jammed_episode):
    one = jammed_episode
    rows = [dict(zip(COLUMNS, row, strict=True)) for row in trace(one, "it", 0, one.steps)]
    agents = [row for row in rows if row["node"] != "source"]
    assert len(agents) == (one.steps + 1) * one.agents
    sent = 0
    for row in agents:
        step, agent = row["step"], int(row["node"])
        assert (row["x"], row["y"]) == one.place(step, agent)
        assert row["holds"] == one.holding[step, agent]
        if step == one.steps:
            assert row["action"] is row["rule"] is row["sent_to"] is None
            continue
        assert (NOBODY if row["rule"] is None else row["rule"]) == one.rule[step, agent]
        if row["rule"] is not None:
            assert row["condition"] == one.rules.text(agent, row["rule"])
            assert row["condition"].endswith(row["action"])
        sent += row["sent_to"] is not None
    assert sent == (one.sent_to != NOBODY).sum() > 0
    served = [row for row in rows if row["node"] == "source"]
    assert len(served) == (one.served != NOBODY).sum() > 0
    told = [(one.served[row["step"]].max(), row["fate"]) for row in served]
    assert all(str(agent) == row["sent_to"] for (agent, _), row in zip(told, served, strict=True))
    assert {fate for _, fate in told} <= {"delivered", "weak", "jammed", "interference", "refused"}


def test_csv_and_parquet_hold_the_same(episode, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    counts = {write_trace(tmp_path / name, [episode], ["it"], start=3, end=20) for name in ("a.csv", "a.parquet")}
    assert len(counts) == 1
    table = parquet.read_table(tmp_path / "a.parquet")
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert table.column_names == list(COLUMNS) == list(rows[0])
    assert table.num_rows == len(rows) == counts.pop()
    for mine, his in zip(rows, table.to_pylist(), strict=True):
        assert mine["action"] == (his["action"] or "")
        assert mine["rule"] == ("" if his["rule"] is None else str(his["rule"]))
        assert float(mine["x"]) == his["x"]
    assert table.schema.field("x").metadata == {b"meaning": b"m, from the source"}


def test_the_command(finished, tmp_path, capsys):
    out = tmp_path / "trace.csv"
    assert cli.main(["replay", str(finished), f"out={out}", "end=10"]) == 0
    assert f"table {out}: " in capsys.readouterr().out
    with out.open() as file:
        steps = {int(row["step"]) for row in csv.DictReader(file)}
    assert steps == set(range(11))
    assert cli.main(["replay", str(finished), f"out={out}"]) == 2
    assert "exists; accepted is a new file" in capsys.readouterr().err
