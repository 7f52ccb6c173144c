"""Documents, archives and rows: the same comes back; foreign, newer and damaged ones are told apart."""

import json

import numpy as np
import pytest

from slcs2_jax.config import InputError
from slcs2_jax.results.archive import check_arrays, read_archive, write_archive
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
    import zipfile

    header = np.lib.format.magic(1, 0)
    text = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }".ljust(117) + "\n"
    with zipfile.ZipFile(tmp_path / "x.npz", "w") as archive:
        archive.writestr("x.npy", header + len(text).to_bytes(2, "little") + text.encode())
    with pytest.raises(InputError, match="not as long as its header says"):
        read_archive(tmp_path / "x.npz", "slcs2_jax thing 1")


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
