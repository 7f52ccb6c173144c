"""Ten tasks of a new user are done by what the documentation says alone; and what it does not say is noticed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.documentation import ROOT

sys.path.append(str(ROOT / "scripts"))
import new_user


@pytest.fixture(scope="session")
def site(tmp_path_factory) -> Path:
    """The documentation as a site."""
    folder = tmp_path_factory.mktemp("docs") / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(folder)]
    subprocess.run(command, cwd=ROOT, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, check=True, timeout=300)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("task", new_user.TASKS, ids=lambda task: task.__name__)
def test_a_task_is_done(task, site, tmp_path, readers_cache, monkeypatch):
    for variable in [name for name in os.environ if name.startswith(("JAX_", "XLA_"))]:
        monkeypatch.delenv(variable)
    monkeypatch.setenv("XDG_CACHE_HOME", str(readers_cache))
    reader = new_user.Reader(site, tmp_path)
    assert task(reader)
    assert 1 <= len(reader.pages) <= new_user.MOST_PAGES


def test_there_are_ten():
    assert len(new_user.TASKS) == len({task.__doc__ for task in new_user.TASKS}) == 10


PAGE = """<nav>cite by hand</nav><article><h1>Cite</h1><p>as follows</p><div><span class="filename">own.py</span><pre>
<span></span><code>x = <span class="m">1</span></code></pre></div>
<pre><code>echo one &amp;&amp; echo 2</code></pre></article>"""
INDEX = """{"docs": [{"location": "other.html", "title": "Other", "text": "<p>cite cite cite</p>"},
                   {"location": "cite.html#as", "title": "Cite", "text": "as follows"}]}"""


@pytest.fixture
def small(tmp_path) -> Path:
    """A site of two pages."""
    (tmp_path / "search").mkdir()
    (tmp_path / "search" / "search_index.json").write_text(INDEX)
    (tmp_path / "cite.html").write_text(PAGE)
    (tmp_path / "other.html").write_text("<article>nothing</article>")
    return tmp_path


def test_a_reader_finds_opens_saves_and_runs(small, tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    reader = new_user.Reader(small, folder)
    assert new_user.found(small, "cite") == ["cite.html", "other.html"], "titles count most"
    reader.look_for("cite", "as follows")
    assert reader.pages == ["cite.html"]
    assert (folder / "own.py").read_text().strip() == "x = 1"
    assert reader.run("echo one", more="2 -> 3 > three") == "one\n"
    assert reader.has("thr*") == "three"


@pytest.mark.parametrize(
    "does",
    [
        lambda reader: reader.look_for("cite", "by hand"),  # stands in a menu alone
        lambda reader: reader.look_for("unheard", "."),
        lambda reader: (reader.look_for("cite", "as"), reader.read("differently")),
        lambda reader: (reader.look_for("cite", "as"), reader.run("no such block")),
        lambda reader: (reader.look_for("cite", "as"), reader.run("echo", change="4 -> 5")),
        lambda reader: (reader.look_for("cite", "as"), reader.run("echo", change="echo -> false ||")),
        lambda reader: reader.has("*.svg"),
    ],
)
def test_what_is_not_said_or_does_not_work_is_noticed(small, does):
    with pytest.raises(new_user.NotDone):
        does(new_user.Reader(small, small))


def test_what_could_not_be_done_is_told(small, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["new_user.py", str(small)])
    monkeypatch.setattr(new_user, "TASKS", (new_user.cite,))
    assert new_user.main() == 1
    assert "not done: cite.html, other.html does not say" in capsys.readouterr().out
