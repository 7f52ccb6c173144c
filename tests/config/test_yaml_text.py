"""YAML is read without believing it."""

import pytest

from slcs2_jax.config import InputError
from slcs2_jax.config.yaml_text import MOST_BYTES, parse_yaml


def test_plain_yaml():
    assert parse_yaml(b"a: [1, 2.5, null, yes]\nb: {c: 'x y'}\n") == {"a": [1, 2.5, None, True], "b": {"c": "x y"}}
    assert parse_yaml("3") == 3


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: &x 1\nb: *x\n", "line 1: an anchor or an alias"),
        ("a: *x\n", "line 1: an anchor or an alias"),
        ("[" * 25, "nested deeper than 24"),
        ("{a: " * 25, "nested deeper than 24"),
        ("[" * 10**6, "nest"),  # newer scanners have a limit of their own, and say so
        ("{a: " * 10**5, "nest"),
        ("a: 1" + ":1" * 10**5, "a number of 200001 letters"),
        ("a: 1" * MOST_BYTES, "bytes of YAML; accepted are at most 1,048,576"),
        ("!!python/object/apply:os.system [true]", "no YAML, or cut short"),
        ("a: [1", "no YAML, or cut short"),
        ("? {}\n: 1\n", "no YAML, or cut short"),
        (b"\xff\xfe\x00", "no YAML, or cut short"),
    ],
)
def test_what_no_file_of_ours_holds_is_refused_in_one_line(text, says):
    with pytest.raises(InputError) as error:
        parse_yaml(text)
    assert says in str(error.value)
    assert "\n" not in str(error.value)
