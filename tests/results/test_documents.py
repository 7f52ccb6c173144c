"""Documents, archives and rows: the same comes back; foreign, newer and damaged ones are told apart."""

import io
import json
import os
import struct
import zipfile

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.results.archive import Limits, check_arrays, read_archive, write_archive
from slcs2_jax.results.documents import checksum, read_document, write_document
from slcs2_jax.results.rows import append_rows, cut_rows, parse_row, read_rows, row_line, sort_rows

# -- documents ---------------------------------------------------------------------------------------------------------


def test_a_document_comes_back(tmp_path):
    content = {"a": 1, "b": [0.1, None, "é"], "c": {"d": True}}
    write_document(tmp_path / "x.json", "thing", 3, content)
    assert read_document(tmp_path / "x.json", "thing", 3) == content


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "no JSON"),
        ("[]", "JSON object"),
        ('{"a": NaN}', "NaN is no finite number"),
        ("[" * 10**5, "no JSON"),
        ('{"a": [' + "[]," * 10**5 + "[]]}", "no JSON of slcs2: more lists and mappings"),
        ('{"format": "slcs2_jax thing 3", "a": 1e999}', "Out of range float values"),
        ('{"a": 1}', "format null; accepted is 'slcs2_jax thing 3'"),
        ('{"format": "other thing 3"}', "format other thing 3"),
        ('{"format": "slcs2_jax other 3"}', "format slcs2_jax other 3"),
        ('{"format": "slcs2_jax thing 4"}', "version 4 of a newer slcs2_jax; accepted is version 3: update"),
        ('{"format": "slcs2_jax thing 2"}', "version 2 of an older slcs2_jax; accepted is version 3"),
        ('{"format": "slcs2_jax thing 3"}', "checksum"),
        ('{"format": "slcs2_jax thing 3", "a": 2, "checksum": "00000000"}', "checksum"),
    ],
)
def test_what_is_no_document_is_refused(tmp_path, text, part):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(InputError) as error:
        read_document(tmp_path / "x.json", "thing", 3)
    assert part in str(error.value)


def test_a_checksum_does_not_depend_on_the_order_of_keys():
    assert checksum({"a": 1, "b": 2}) == checksum({"b": 2, "a": 1}) != checksum({"a": 2, "b": 1})


# -- archives ----------------------------------------------------------------------------------------------------------


def test_an_archive_comes_back_and_equal_content_has_equal_bytes(tmp_path):
    arrays = {"x": np.arange(6, dtype=np.int32).reshape(2, 3), "none": np.empty((0, 4), np.float32)}
    for name in ("a.npz", "b.npz"):
        write_archive(tmp_path / name, "slcs2_jax thing 1", arrays, {"k": [1]})
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    found, about = read_archive(tmp_path / "a.npz", "slcs2_jax thing 1")
    check_arrays(found, {"x": (np.int32, (2, 3)), "none": (np.float32, (0, 4))})
    np.testing.assert_array_equal(found["x"], arrays["x"])
    assert about == {"k": [1]}


def test_an_archive_that_claims_to_be_huge_takes_no_memory(tmp_path):
    header = np.lib.format.magic(1, 0)
    text = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }".ljust(117) + "\n"
    with zipfile.ZipFile(tmp_path / "x.npz", "w") as archive:
        archive.writestr("x.npy", header + len(text).to_bytes(2, "little") + text.encode())
    with pytest.raises(InputError, match="not as long as its header says"):
        read_archive(tmp_path / "x.npz", "slcs2_jax thing 1")


def packed(path, sizes, *, kind=zipfile.ZIP_DEFLATED):
    """An archive whose entries are so many zeros."""
    with zipfile.ZipFile(path, "w", kind) as archive:
        for number, size in enumerate(sizes):
            head = io.BytesIO()
            np.lib.format.write_array_header_1_0(head, {"descr": "|u1", "fortran_order": False, "shape": (size,)})
            archive.writestr(f"x{number}.npy", head.getvalue() + bytes(size))


@pytest.mark.parametrize(
    ("sizes", "limits", "says"),
    [
        ([10**7], Limits(size=10**6), "entry x0.npy is too large"),
        ([10**6] * 12, Limits(size=10**7), "would take 12,0.* bytes; accepted are at most 10,000,000"),
        ([0] * 65, Limits(entries=64), "65 entries; accepted are at most 64"),
        ([0] * 3000, Limits(entries=64), "no .npz archive, or cut short"),
        ([10**6], Limits(size=10**6, compressed=False), "entry x0.npy is no array"),
    ],
)
def test_what_an_archive_would_unpack_to_is_looked_at_before(tmp_path, monkeypatch, sizes, limits, says):
    packed(tmp_path / "x.npz", sizes)
    monkeypatch.setattr(zipfile.ZipFile, "open", lambda *_: pytest.fail("something was unpacked"))
    with pytest.raises(InputError, match=says):
        read_archive(tmp_path / "x.npz", "slcs2_jax thing 1", limits)


def test_an_archive_of_its_full_size_is_read(tmp_path):
    """What does not compress is longer than what is in it."""
    chance = np.random.default_rng(0)
    for compressed in (True, False):
        limits = Limits(entries=18, size=16 * 10**6, about=1000, compressed=compressed)
        arrays = {str(n): np.frombuffer(chance.bytes(10**6), np.uint8) for n in range(16)}
        write_archive(tmp_path / "x.npz", "f", arrays, {"a": "x" * 980}, compressed=compressed)
        found, _ = read_archive(tmp_path / "x.npz", "f", limits)
        np.testing.assert_equal(found, arrays)


def test_entries_that_lie_in_each_other_are_refused(tmp_path):
    """A directory that names the same bytes a thousand times."""
    packed(tmp_path / "one.npz", [10**5], kind=zipfile.ZIP_STORED)
    data = (tmp_path / "one.npz").read_bytes()
    start, end = data.index(b"PK\x01\x02"), data.index(b"PK\x05\x06")
    entry = data[start:end]
    many = b"".join(entry.replace(b"x0.npy", b"%02d.npy" % n) for n in range(50))
    tail = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 50, 50, len(many), start, 0)
    (tmp_path / "x.npz").write_bytes(data[:start] + many + tail)
    with pytest.raises(InputError, match="its entries overlap"):
        read_archive(tmp_path / "x.npz", "slcs2_jax thing 1")


def test_arrays_that_are_not_wanted_are_not_unpacked(tmp_path):
    write_archive(tmp_path / "x.npz", "f", {"a": np.arange(3), "b": np.arange(4)}, {})
    found, _ = read_archive(tmp_path / "x.npz", "f", wanted=lambda name: name == "b")
    assert list(found) == ["b"]


def test_objects_are_never_loaded(tmp_path):
    np.savez(tmp_path / "x.npz", format=np.array("f"), about=np.array([{}], dtype=object))
    with pytest.raises(InputError):
        read_archive(tmp_path / "x.npz", "f")


@pytest.mark.parametrize("place", [0, 6, 8, 14, 18, 26, 28])
def test_bits_of_the_headers(tmp_path, place):
    """Among them the one that says that an entry is encrypted."""
    write_archive(tmp_path / "x.npz", "slcs2_jax thing 1", {"x": np.arange(9)}, {})
    data = bytearray((tmp_path / "x.npz").read_bytes())
    central = data.index(b"PK\x01\x02")
    for start in (0, central):
        for bit in range(8):
            changed = bytearray(data)
            changed[start + place] ^= 1 << bit
            (tmp_path / "x.npz").write_bytes(changed)
            try:
                arrays, _ = read_archive(tmp_path / "x.npz", "slcs2_jax thing 1")
            except InputError:
                continue
            np.testing.assert_array_equal(arrays["x"], np.arange(9))


# -- rows --------------------------------------------------------------------------------------------------------------


def row(generation: int, instance: int, **values) -> dict:
    return {"instance": instance, "generation": generation, "best": generation / 7, **values}


def test_rows_come_back_in_order_whatever_order_they_came_in(tmp_path):
    file = tmp_path / "rows.jsonl"
    append_rows(file, [row(0, 1), row(1, 1)])
    append_rows(file, [row(0, 0), row(1, 0)])
    assert read_rows(file) == [row(0, 1), row(1, 1), row(0, 0), row(1, 0)]
    sort_rows(file)
    assert read_rows(file) == [row(0, 0), row(0, 1), row(1, 0), row(1, 1)]
    before = file.stat().st_ino
    sort_rows(file)
    assert file.stat().st_ino == before, "written again without need"


def test_a_row_is_readable_by_anybody():
    line = json.loads(row_line(row(3, 0)))
    assert line.pop("crc")
    assert line == row(3, 0)


def test_cutting_leaves_what_was_saved_and_no_more(tmp_path):
    file = tmp_path / "rows.jsonl"
    append_rows(file, [row(0, 1), row(0, 0), row(1, 1), row(2, 1), row(1, 0)])
    with file.open("ab") as raw:
        raw.write(b"\x00\x00\n" + row_line(row(2, 0))[:20])
    cut_rows(file, [1, 2])
    assert read_rows(file) == [row(0, 1), row(0, 0), row(1, 1)]
    before = file.stat().st_ino
    cut_rows(file, [1, 2])
    assert file.stat().st_ino == before
    cut_rows(file, [0, 0])
    assert file.read_bytes() == b""
    cut_rows(tmp_path / "absent.jsonl", [0, 0])


@pytest.mark.parametrize("saved", [0, 1])
def test_a_row_follows_no_half_written_one(tmp_path, saved):
    file = tmp_path / "rows.jsonl"
    append_rows(file, [row(generation, 0) for generation in range(saved)])
    with file.open("ab") as raw:
        raw.write(row_line(row(saved, 0))[:20])
    cut_rows(file, [saved])
    append_rows(file, [row(saved, 0)])
    assert read_rows(file) == [row(generation, 0) for generation in range(saved + 1)]


@pytest.mark.parametrize("lines", [[row(0, 0)], [row(1, 0)], [row(0, 0), row(0, 0), row(1, 0)]])
def test_a_row_that_was_saved_and_is_not_there_is_named(tmp_path, lines):
    append_rows(tmp_path / "rows.jsonl", lines)
    before = (tmp_path / "rows.jsonl").read_bytes()
    with pytest.raises(InputError, match=r"generation [01] of instance 0 is (missing or damaged|there twice)"):
        cut_rows(tmp_path / "rows.jsonl", [2])
    assert (tmp_path / "rows.jsonl").read_bytes() == before


def test_more_lines_or_longer_ones_than_a_run_has_are_refused(tmp_path):
    file = tmp_path / "rows.jsonl"
    append_rows(file, [row(n, 0) for n in range(4)])
    assert len(read_rows(file, 4)) == 4
    for read in (lambda: read_rows(file, 3), lambda: cut_rows(file, [1], 3), lambda: sort_rows(file, 3)):
        with pytest.raises(InputError, match="more than 3 lines"):
            read()
    file.write_bytes(b" " * 5000)
    with pytest.raises(InputError, match="line 1: longer than 4096 bytes"):
        read_rows(file, 4)
    file.touch()
    os.truncate(file, 10**12)
    with pytest.raises(InputError, match="1,000,000,000,000 bytes; accepted are at most 16,384"):
        cut_rows(file, [1], 4)


def test_two_rows_run_into_one_are_no_row():
    one, other = row_line(row(0, 0)), row_line(row(0, 1))
    merged = one[: one.index(b'"generation"')] + other[1:-1]
    with pytest.raises(InputError, match="a name is there twice"):
        parse_row(merged)


def test_every_flipped_bit_of_a_row_is_found():
    line = row_line(row(3, 1, contribution=[0.5, 2.0]))[:-1]
    for place in range(len(line)):
        for bit in range(8):
            changed = bytearray(line)
            changed[place] ^= 1 << bit
            try:
                found = parse_row(bytes(changed))
            except InputError:
                continue
            assert found == parse_row(line), changed
