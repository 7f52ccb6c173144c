"""The oracle stands beside the tests: the installed package neither holds nor imports it."""

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SHIPPED = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]


def test_the_wheel_holds_no_tests():
    assert SHIPPED == ["slcs2_jax", "hydra_plugins"]


@pytest.mark.parametrize("name", SHIPPED)
def test_the_package_imports_no_oracle(name):
    for path in (ROOT / name).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            assert not [name for name in names if name.split(".")[0] in ("tests", "benchmarks")], path
