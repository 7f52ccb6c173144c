"""The notebooks run from a fresh kernel in an empty folder, and their pages show what they came to."""

from __future__ import annotations

import os
import re
import sys

import nbformat
import pytest
from nbclient import NotebookClient

from tests.documentation import ROOT

sys.path.append(str(ROOT / "scripts"))
import docs_notebooks

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
MOST_BYTES = 500_000
NAMES = {"first_swarm", "network", "own_search"}


def code(notebook) -> list:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def kinds(notebook) -> list[list[str]]:
    """What each code cell shows: text, or the kind of picture."""
    return [
        [output.name if output.output_type == "stream" else max(output.data) for output in cell.outputs]
        for cell in code(notebook)
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_kept_notebook_is_small_was_run_from_top_to_bottom_and_knows_no_checkout(path):
    notebook = nbformat.read(path, 4)
    nbformat.validate(notebook)
    assert path.stat().st_size < MOST_BYTES
    assert [cell.execution_count for cell in code(notebook)] == list(range(1, len(code(notebook)) + 1))
    assert {kind for cell in kinds(notebook) for kind in cell} <= {"stdout", "text/plain"}
    said = "\n".join(cell.source for cell in code(notebook))
    assert not re.search(r"sys\.path|\.\./|examples/|scripts/|(?<![\w.])/\w+", said)
    assert notebook.metadata.kernelspec.name == "python3"


def test_there_are_three_and_every_link_leads_somewhere():
    assert {path.stem for path in NOTEBOOKS} == NAMES
    made = {"../reference/settings.md", "../reference/api.md"}
    for path in NOTEBOOKS:
        text = "\n".join(cell.source for cell in nbformat.read(path, 4).cells if cell.cell_type == "markdown")
        links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)]+)\)", text)]
        assert links
        assert [link for link in links if link not in made and not (path.parent / link).is_file()] == []


def test_a_page_shows_every_output():
    files = docs_notebooks.notebook_files()
    for path in NOTEBOOKS:
        notebook, page = nbformat.read(path, 4), files[f"notebooks/{path.stem}.md"]
        shown = 0
        for cell in code(notebook):
            assert cell.source in page
            for output in cell.outputs:
                if output.output_type == "stream":
                    assert output.text.strip() in page
                else:
                    shown += 1
        pictures = re.findall(r"!\[.*\]\((.*)\)", page)
        assert len(pictures) == shown
        for picture in pictures:
            assert files[f"notebooks/{picture}"][:4] in (b"\x89PNG", b"GIF8")
        assert ".ipynb" not in page.replace(f"({path.stem}.ipynb)", "")


def test_an_output_that_no_page_can_show_is_named():
    cell = {"cell_type": "code", "source": ["x"], "outputs": [{"output_type": "error", "ename": "E"}]}
    with pytest.raises(ValueError, match="mine: no way to show error"):
        docs_notebooks.page("mine", {"cells": [cell]})


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs_from_a_fresh_kernel(path, tmp_path, monkeypatch):
    """With the package of SLCS2_SITE, where .ci/run puts the wheel, else with this checkout's."""
    for variable in [name for name in os.environ if name.startswith(("JAX_", "XLA_"))]:
        monkeypatch.delenv(variable)
    monkeypatch.setenv("JAX_PLATFORMS", "cpu")
    monkeypatch.setenv("PYTHONPATH", os.environ.get("SLCS2_SITE", str(ROOT)))
    kept = nbformat.read(path, 4)
    notebook = nbformat.read(path, 4)
    notebook.cells.append(nbformat.v4.new_code_cell("print(slcs2.__file__)"))
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    home = notebook.cells.pop().outputs[0].text
    assert home.startswith(os.environ["PYTHONPATH"])
    assert kinds(notebook) == kinds(kept)
