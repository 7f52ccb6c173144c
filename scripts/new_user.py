"""Ten tasks of a new user, each done by what the documentation says alone.

mkdocs build --site-dir SITE && python scripts/new_user.py SITE

A reader types some words into the search of the site, opens what it finds, page after page, until one says how it is
done; then does that, in an empty folder, with smaller sizes where the page's are not small. Prints for each task how
many pages were opened, how long it took, and what was there in the end.
"""

from __future__ import annotations

import argparse
import html
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path

MOST_PAGES = 4  # whoever has opened so many gives up
TITLE = 1000.0  # what a word in a title counts beside one in a text, as in the site's own search


class NotDone(Exception):
    """The documentation does not tell how a task is done, or what it tells does not do it."""


class Page(HTMLParser):
    """What a page shows: its text, and its code blocks as (name of a file or "", text)."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.blocks: list[tuple[str, str]] = []
        self.text = ""
        self._name, self._in, self._code, self._article = "", "", "", 0
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Notice where articles, names of files and blocks begin."""
        kind = dict(attrs).get("class") or ""
        self._article += tag == "article"
        if tag == "span" and kind == "filename":
            self._in = "name"
        elif tag == "pre":
            self._in, self._code = "code", ""

    def handle_endtag(self, tag: str) -> None:
        """Notice where they end."""
        self._article -= tag == "article"
        if tag == "pre":
            self.blocks.append((self._name, self._code))
            self._name = self._in = ""
        elif tag == "span" and self._in == "name":
            self._in = ""

    def handle_data(self, data: str) -> None:
        """Take the text of an article."""
        if not self._article:
            return
        self.text += data
        if self._in == "name":
            self._name += data
        elif self._in == "code":
            self._code += data


def found(site: Path, words: str) -> list[str]:
    """The pages that the site's index has for some words, the most fitting first: titles count most, rare words more
    than frequent ones."""
    entries = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))["docs"]
    wanted = words.lower().split()
    said = [
        (
            entry["location"].partition("#")[0],
            html.unescape(entry["title"]).lower(),
            html.unescape(re.sub("<[^>]+>", " ", entry["text"])).lower(),
        )
        for entry in entries
    ]
    known = {word: sum(word in title + text for _, title, text in said) for word in wanted}
    scores: dict[str, float] = defaultdict(float)
    for page, title, text in said:
        score = 0.0
        for word in wanted:
            count, rare = len(re.findall(rf"\b{re.escape(word)}", text)), math.log(1 + len(said) / (1 + known[word]))
            score += rare * (count / (count + 1 + len(text) / 1000) + TITLE * bool(re.search(rf"\b{word}", title)))
        scores[page] = max(scores[page], score)
    return sorted((page for page, score in scores.items() if score), key=lambda page: -scores[page])


@dataclass
class Reader:
    """Somebody with the site, a shell and an empty folder."""

    site: Path
    folder: Path
    pages: list[str] = field(default_factory=list)
    page: Page = field(init=False)

    def look_for(self, words: str, answer: str) -> None:
        """Open what the search finds until a page has what is looked for, a regular expression; save its files."""
        for name in found(self.site, words)[:MOST_PAGES]:
            self.pages.append(name)
            self.page = Page(self.site / name)
            if re.search(answer, self.page.text):
                for title, text in self.page.blocks:
                    if title:
                        (self.folder / title).write_text(text, encoding="utf-8")
                return
        raise NotDone(f"{', '.join(self.pages) or 'no page'} does not say {answer}")

    def read(self, pattern: str) -> str:
        """What the page says there."""
        match = re.search(pattern, self.page.text)
        if match is None:
            raise NotDone(f"{self.pages[-1]} does not say {pattern}")
        return " ".join(match[0].split())

    def run(self, pattern: str, **changes: str) -> str:
        """Run the page's block that has this in it, a shell's or Python's, and return what it prints.

        changes: words of the block that this user's case has others for, by any name: "before -> after".
        """
        text = next((text for name, text in self.page.blocks if not name and re.search(pattern, text)), None)
        if text is None:
            raise NotDone(f"{self.pages[-1]} has no block with {pattern}")
        for change in changes.values():
            before, after = change.split(" -> ")
            if before not in text:
                raise NotDone(f"{self.pages[-1]}: no {before} in {text}")
            text = text.replace(before, after)
        command = [sys.executable, "-c"] if re.match(r"(import|from) ", text) else ["bash", "-euo", "pipefail", "-c"]
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run(
            [*command, text],
            cwd=self.folder,
            env={**os.environ, "PATH": path, "JAX_PLATFORMS": "cpu"},
            capture_output=True,
            text=True,
            timeout=600,
        )
        if done.returncode != 0:
            raise NotDone(f"{self.pages[-1]}: {text}{done.stderr}")
        return done.stdout

    def has(self, pattern: str) -> str:
        """The files that are there by now and match; there must be one."""
        there = sorted(str(path.relative_to(self.folder)) for path in self.folder.glob(pattern))
        if not there:
            raise NotDone(f"no {pattern} in the folder")
        return there[0]


def sweep(reader: Reader) -> str:
    """Sweep an assumed value and plot it."""
    reader.look_for("sweep assumed value", r"slcs2 evolve -m radio\.path_loss_exponent=")
    reader.run("evolve -m radio.path_loss_exponent", value="radio.path_loss_exponent=2.6,2.8,3.0 -> swarm.speed=1,2")
    return reader.has("runs/exponent/report/*speed*.svg")


def beside(reader: Reader) -> str:
    """Put an own rule-set beside the evolved one."""
    reader.look_for("own rules beside evolved", r"beside=carry\.txt")
    reader.run("cat > carry.txt")
    reader.run("run_dir=runs/slcs2")
    table = reader.run(r'load_decision_list\("carry.txt"\)')
    reader.run("beside=carry.txt")
    reader.has("*.gif")
    return "; ".join(table.splitlines())


def clause(reader: Reader) -> str:
    """Add a clause."""
    reader.look_for("own clause", r'register\("clause"')
    name = re.search(r'register\("clause", "([^"]+)"', "".join(text for _, text in reader.page.blocks))
    listed = reader.run("parts clause")
    if name is None or name[1] not in listed:
        raise NotDone(f"slcs2 parts does not list it: {listed}")
    return f"slcs2 parts lists {name[1]}"


def trace(reader: Reader) -> str:
    """Export a trace."""
    reader.look_for("export trace table csv", r"out=trace\.csv")
    reader.run("evolve .*run_dir=runs/urban")
    reader.run(r"out=trace\.csv")
    return (reader.folder / reader.has("trace.csv")).read_text(encoding="utf-8").partition("\n")[0]


def epsilon(reader: Reader) -> str:
    """Find what ε means."""
    reader.look_for("ε", r"error ε")
    return reader.read(r"quality q, strength ζ,\s+error ε[^.\n]*")


def unit(reader: Reader) -> str:
    """Find the unit of d_th."""
    reader.look_for("unit of d_th", r"d_th\s+50 m|d_th, the fixed distance")
    return reader.read(r"d_th\s+50 m|swarm\.distance_threshold\s+50(\.0)?\s+m\s")


def resume(reader: Reader) -> str:
    """Resume."""
    reader.look_for("resume stopped run", r"slcs2 resume runs/mine")
    reader.run("slcs2 resume runs/mine")
    rows = (reader.folder / "runs/mine/generations.jsonl").read_text(encoding="utf-8").splitlines()
    if len(rows) != 3:
        raise NotDone(f"{len(rows)} generations in place of 3")
    return f"{len(rows)} generations"


def cite(reader: Reader) -> str:
    """Cite."""
    reader.look_for("cite", r"@article\{")
    [entry] = [text for _, text in reader.page.blocks if text.startswith("@article{")]
    if entry.count("{") != entry.count("}") or "1910.12412" not in entry:
        raise NotDone(f"no BibTeX: {entry}")
    return entry.splitlines()[0]


def slurm(reader: Reader) -> str:
    """Run on Slurm, tried out as the page says: without a queue."""
    reader.look_for("slurm", r"hydra/launcher=submitit_slurm")
    reader.read(r"hydra/launcher=submitit_local takes the same options")
    small = "instances=1 generations=1 world.time_limit=200 search.fresh_deployments=1 compute.devices=1"
    reader.run(
        "evolve -m .*submitit_slurm",
        launcher="submitit_slurm -> submitit_local",
        worlds="environment=open,urban range=short,long -> environment=open,urban",
        jobs="/shared/jobs -> jobs",
        folder=f"/shared/sweep -> sweep {small}",
    )
    reader.has("jobs/.submitit/*")
    return reader.has("sweep/*/summary.json")


def train(reader: Reader) -> str:
    """Train a network."""
    reader.look_for("train network", r"optax")
    said = reader.run(r"python train\.py")
    return next(line for line in said.splitlines() if line.startswith("network:"))


TASKS: tuple[Callable[[Reader], str], ...] = (
    *(sweep, beside, clause, trace, epsilon),
    *(unit, resume, cite, slurm, train),
)


def main() -> int:
    """Do all tasks; 1 if one was not done."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("site", type=Path, help="folder that mkdocs build made")
    site, bad = parser.parse_args().site, 0
    print("| task | pages | seconds | in the end |\n|---|--:|--:|---|")
    for task in TASKS:
        with tempfile.TemporaryDirectory(prefix="slcs2-") as folder:
            reader, start = Reader(site, Path(folder)), time.perf_counter()
            try:
                end = task(reader)
            except NotDone as error:
                bad, end = 1, f"not done: {error}"
            seconds = time.perf_counter() - start
            print(f"| {(task.__doc__ or '').rstrip('.')} | {len(reader.pages)} | {seconds:.1f} | {end} |", flush=True)
    return bad


if __name__ == "__main__":
    sys.exit(main())
