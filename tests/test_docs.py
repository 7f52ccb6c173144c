"""The documentation tells the truth: its commands and code run, and its tables and figures are those of the runs."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
import tarfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from scipy.stats import spearmanr

import slcs2_jax
from slcs2_jax.config.field import described
from slcs2_jax.config.table import settings_table
from slcs2_jax.looking.rulebook import rule_lines
from slcs2_jax.results import load_solution
from slcs2_jax.search import HistoryRow
from slcs2_jax.study.claim import Verdict
from slcs2_jax.study.statistics import compare
from tests.documentation import PAGES, README, ROOT, blocks, follow

sys.path.append(str(ROOT / "scripts"))
import docs_pages

DOCS = ROOT / "docs"
TO_FOLLOW = [page for page in PAGES if any(block.runs for block in blocks(page))]


def text(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def numbers(cell: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", cell.replace("−", "-"))]


def read_in(archive: tarfile.TarFile, name: str) -> str:
    file = archive.extractfile(name)
    assert file is not None
    return file.read().decode()


def rows_of(archive: tarfile.TarFile, run: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in read_in(archive, f"{run}/generations.jsonl").splitlines()]


def fresh_of(archive: tarfile.TarFile, run: str) -> float:
    [instance] = json.loads(read_in(archive, f"{run}/summary.json"))["instances"]
    return instance["fresh_mean"]


SPENDING = "best", "deployments"  # of a row: the search's best so far, and the episodes of its generation


def at_equal_episodes(best: NDArray[np.float64], spent: NDArray[np.int64]) -> tuple[float, ...]:
    """Two algorithms' best so far, pair by pair, where the thriftier of each pair ended: difference, interval, p.

    best, spent: [2, pairs, generations]; spent is cumulative.
    """
    equal = spent[:, :, -1].min(axis=0)
    at = np.array(
        [[np.searchsorted(*pair, side="right") - 1 for pair in zip(arm, equal, strict=True)] for arm in spent]
    )
    found = compare(*np.take_along_axis(best, at[:, :, None], axis=2)[:, :, 0])
    assert found.bootstrap is not None
    return found.difference, *found.bootstrap, found.p_wilcoxon


@pytest.mark.slow
@pytest.mark.parametrize("page", TO_FOLLOW, ids=lambda page: page.stem)
def test_a_reader_who_follows_a_page_gets_through(page, tmp_path, readers_cache):
    for block in blocks(page):
        follow(block, tmp_path, readers_cache)


def test_blocks_are_of_known_kinds_and_what_is_not_run_says_why():
    for page in (README, *PAGES):
        said = page.read_text(encoding="utf-8")
        assert {block.kind for block in blocks(page)} <= {"bash", "python", "text", "bibtex"}, page
        assert all(len(why) > 10 for why in re.findall(r"<!-- not run:?(.*?)-->", said)), page


def test_every_page_stands_in_the_menu():
    def paths(entry):
        if isinstance(entry, str):
            return [entry]
        entries = entry.values() if isinstance(entry, dict) else entry
        return [path for one in entries for path in paths(one)]

    menu = paths(yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))["nav"])
    made = {"reference/api.md", "reference/settings.md"}
    made |= {f"notebooks/{path.stem}.md" for path in (DOCS / "notebooks").glob("*.ipynb")}
    assert len(set(menu)) == len(menu)
    assert set(menu) - made == {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")}


def test_the_reference_has_every_public_name():
    page = docs_pages.api_markdown()
    for name in slcs2_jax._HOME:
        assert f"\n::: {docs_pages.defined(name)}\n" in page, name


def test_every_assumed_value_has_its_row_with_the_studys_figures():
    table = docs_pages.assumed_markdown()
    for row in settings_table():
        assert table.count(f"\n| `{row.name}` |") == (row.status in ("assumed", "calibrated")), row.name
    assert "1000: 0.676" in next(line for line in table.splitlines() if "`swarm.packets`" in line)
    assert docs_pages.ASSUMED in text("model.md")


def test_every_setting_of_a_training_has_its_row():
    page = text("howto/train_network.md")
    for place, section in docs_pages.LEARNING.items():
        assert place in page
        table = docs_pages.section_markdown(section)
        assert all(f"\n| `{field.name}` | " in table for field in described(section))


@pytest.mark.parametrize(
    ("name", "arms"),
    [
        ("searches_1000", ["informed search, 1000 episodes", "SLCS2, 1000 episodes", "designed"]),
        ("searches_200", ["informed search, 200 episodes", "random search with knowledge, 200 episodes",
               "the best of two starters, 200 episodes", "knowledge alone", "SLCS2, 200 episodes", "designed"]),
        ("control_200", ["SLCS2, 200 episodes", "random search, 200 episodes"]),
    ],
)  # fmt: skip
def test_the_tables_of_searches_are_those_of_the_runs(name, arms):
    file = f"{name}_fitness.csv"
    page = text("results/searches/README.md")
    shown = re.search(rf"^<!-- results: [^\n]*{file} -->\n(.*?)^<!-- end", page, re.M | re.S)
    assert shown is not None
    with (DOCS / "results" / "searches" / file).open(encoding="utf-8") as source:
        figures = {(row["world"], row["arm"]): float(row["fresh mean"]) for row in csv.DictReader(source)}
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in shown[1].splitlines()[2:]]
    assert len(rows) == 10
    for world, *cells in rows:
        said = [float(cell.replace("−", "-")) for cell in cells[: len(arms)]]
        assert said == [round(figures[world, arm], 3) for arm in arms], world


def test_what_is_said_of_random_search_is_what_the_contests_say():
    def rows(measure, kind):
        with (DOCS / "results" / "searches" / f"control_200_{measure}_{kind}.csv").open(encoding="utf-8") as file:
            return list(csv.DictReader(file))

    [everywhere] = (row for row in rows("fresh", "overall") if row["worlds"] == "all")
    behind = re.search(
        r"random search is behind the paper's search .*?, by ([\d.]+);", README.read_text(encoding="utf-8")
    )
    assert behind is not None
    assert behind[1] == f"{float(everywhere['difference']):.3f}"
    worlds = {row["world"]: row for row in rows("fresh", "comparisons") if "overall" not in row["world"]}
    assert all(float(row["difference"]) > 0 for row in worlds.values())
    shown = {world for world, row in worlds.items() if float(row["Holm p"]) < 0.05}
    assert shown == {world for world in worlds if "jammed" in world}
    assert f"p {max(float(worlds[world]['Holm p']) for world in shown):.3f} at most" in text(
        "results/searches/README.md"
    )
    for measure, pages in (("fresh", ("searches/README.md", "index.md")), ("best", ("searches/README.md",))):
        row = next(row for row in rows(measure, "overall") if row["worlds"] == "all")
        assert row["cells ahead"] == row["cells"] == "8"
        found = [float(row[name]) for name in ("difference", "BCa 90 low", "BCa 90 high")]
        for page in pages:
            said = text(f"results/{page}").replace("BCa 90 %: ", "").replace("permutation ", "")
            assert "{:.3f} ({:.3f} to {:.3f}; p {}".format(*found, row["permutation p"]) in said


def test_what_is_said_of_1000_episodes_is_what_the_contests_say():
    """Worlds in which the informed search's mean is greater, significantly after Holm, and by the paper's rule."""
    with (DOCS / "results" / "searches" / "searches_1000_fresh_comparisons.csv").open(encoding="utf-8") as file:
        contests = [row for row in csv.DictReader(file) if "overall" not in row["world"]]
    page = text("results/searches/README.md")
    for opponent, ahead, shown, by_the_paper, said in (
        ("designed", 8, 1, 6, "**In all eight worlds the mean is above the designed behaviour's**"),
        ("SLCS2, 1000 episodes", 8, 5, 6, "**It is above the paper's search in all eight**"),
    ):
        against = [row for row in contests if row["against"] == opponent]
        assert sum(float(row["difference"]) > 0 for row in against) == ahead == len(against)
        assert sum(float(row["Holm p"]) < 0.05 for row in against) == shown
        assert sum(row["superior (the paper's rule)"].endswith(", significantly") for row in against) == by_the_paper
        assert said in page
    assert "one of them is below 0.05" in page
    assert "By the paper's own rule six are significant" in page
    assert "after Holm's correction in five worlds" in page


def test_the_table_of_the_ablation_is_that_of_the_runs():
    shown = re.search(r"^<!-- results: .*?-->\n(.*?)^<!-- end", text("results/ablation/README.md"), re.M | re.S)
    assert shown is not None
    with (DOCS / "results" / "ablation" / "ablation_150_fitness.csv").open(encoding="utf-8") as file:
        figures = {(row["world"], row["arm"]): float(row["fresh mean"]) for row in csv.DictReader(file)}
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in shown[1].splitlines()[2:]]
    assert {arm for arm, *_ in rows} == {arm.removesuffix(", 150 episodes") for _, arm in figures}
    worlds = ("short open", "short jammed", "short urban", "short urban jammed", "short overall")
    for arm, *cells in rows:
        said = [float(cell.replace("−", "-")) for cell in cells[:5]]
        assert said == [round(figures[world, f"{arm}, 150 episodes"], 3) for world in worlds], arm


@pytest.mark.parametrize(("page", "count"), [(DOCS / "results" / "index.md", 10), (README, 2)], ids=["docs", "README"])
def test_the_table_of_results_is_that_of_the_runs(page, count):
    said = page.read_text(encoding="utf-8")
    shown = re.search(r"^<!-- results: .*?-->\n(.*?)^<!-- end of results -->$", said, re.M | re.S)
    assert shown is not None
    figures = {}
    for experiment in ("contributions", "designed", "grammars"):
        with (DOCS / "results" / "paper" / f"{experiment}_fitness.csv").open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                figures[row["world"], row["arm"]] = float(row["fresh mean"]), float(row["best mean"])
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in shown[1].splitlines()[2:]]
    assert len(rows) == count
    arms = (
        "SLCS2",
        "no novelty (AILTA)",
        "no exchange",
        "designed",
        "grammar channel",
        "grammar power",
        "grammar both",
    )
    for world, *cells in rows:
        for arm, cell in zip(arms, cells, strict=True):
            told = [float(number) for number in re.findall(r"[\d.-]+", cell.replace("−", "-"))]
            assert told == [round(number, 3) for number in figures[world, arm]][: len(told)], (world, arm)


def test_the_counts_of_verdicts_that_are_told_are_those_of_the_runs():
    findings = json.loads((DOCS / "results" / "paper" / "verdicts.json").read_text(encoding="utf-8"))
    counts = {
        metric: [sum(one["verdict"] == verdict for one in findings if one["metric"] == metric) for verdict in Verdict]
        for metric in ("fresh", "best")
    }
    assert counts["fresh"][3] == counts["best"][3] == 0  # no claim lacks data
    holds, direction, fails = counts["fresh"][:3]
    assert (
        f"Of the paper's {sum(counts['fresh'])} claims {holds} hold, {direction} hold in direction and {fails} do not"
        in (README.read_text(encoding="utf-8"))
    )
    page = text("results/paper/README.md")
    assert (
        f"By fresh means {holds} of the paper's 33 claims hold, {direction} hold in direction, {fails} do not;" in page
    )
    assert "; by best {}, {} and {}.".format(*counts["best"]) in page


def test_the_tables_of_the_sensitivity_study_are_those_of_the_runs():
    folder = DOCS / "results" / "sensitivity"
    with (folder / "sweep_fresh_robustness.csv").open(encoding="utf-8") as file:
        found = {(row["world"], row["against"], row["settings"]): row for row in csv.DictReader(file)}
    page = (folder / "README.md").read_text(encoding="utf-8")
    shown = re.findall(r"^<!-- sensitivity: \S+, (.*?) -->\n(.*?)^<!-- end -->", page, re.M | re.S)
    assert [world for world, _ in shown] == ["long jammed", "long urban jammed"]
    for world, table in shown:
        rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
        compared = {settings for place, _, settings in found if place == world and "emission" not in settings}
        assert {settings for settings, *_ in rows} == compared
        for settings, *cells in rows:
            for against, cell in zip(("no novelty (AILTA)", "no exchange", "designed"), cells, strict=False):
                row = found[world, against, settings]
                names = ("difference", "BCa 90 low", "BCa 90 high")
                assert numbers(cell) == [round(float(row[name]), 3) for name in names], (world, settings)
    asked = [
        row for (world, _, settings), row in found.items() if world == "long jammed" and "emission" not in settings
    ]
    by = {
        against: sorted(float(row["difference"]) for row in asked if row["against"] == against)
        for against in ("no exchange", "no novelty (AILTA)", "designed")
    }
    exchange, novelty, designed = by.values()
    assert {len(some) for some in by.values()} == {15}
    assert f"each of the fifteen points**, by {exchange[0]:.3f} to {exchange[-1]:.3f}:" in page
    assert f"ahead at fourteen**, by {-designed[-2]:.3f} to {-designed[0]:.3f}." in page
    assert f"in the mean it is behind by {designed[-1]:.3f}" in page
    told = f"{novelty[0]:.3f} to {novelty[-1]:.3f}, above zero at thirteen".replace("-", "−")
    assert f"small and uncertain**: {told} of the fifteen" in page
    assert sum(one > 0 for one in novelty) == 13
    with tarfile.open(folder / "runs.tar.bz2") as archive:
        place = "sensitivity/exponent_26/{}/jammed_long/seed_{}"
        evolved = [fresh_of(archive, place.format("slcs2", seed)) for seed in range(5000, 5005)]
        summaries = [json.loads(read_in(archive, place.format("designed", seed) + "/summary.json"))
                     for seed in range(5000, 5005)]  # fmt: skip
    ahead = sorted(np.mean(one["fitness"]) - mine for one, mine in zip(summaries, evolved, strict=True))
    assert ahead[0] < 0
    assert f"in four of the five instances by {ahead[1]:.3f} to {ahead[-1]:.3f}, and fails in the fifth" in page


def test_what_is_said_of_the_joint_search_is_that_of_its_points():
    folder = DOCS / "results" / "calibration"
    page = (folder / "README.md").read_text(encoding="utf-8")
    points, again = (
        {row["settings"]: row for row in csv.DictReader((folder / "joint" / name).read_text("utf-8").splitlines())}
        for name in ("points.csv", "again.csv")
    )
    here, elsewhere = ({name: float(row["misfit"]) for name, row in table.items()} for table in (points, again))
    table = re.search(r"^<!-- joint: .*?-->\n(.*?)^<!-- end of joint", page, re.M | re.S)
    assert table is not None
    shown = [numbers(cell)[0] for line in table[1].splitlines()[2:] for cell in line.strip("|").split("|")[-2:]]
    order = sorted(elsewhere, key=elsewhere.__getitem__)
    assert shown == [round(value[name], 3) for name in order for value in (here, elsewhere)]
    assert order[0] == "defaults"
    joint = [name for name, row in points.items() if row["tried"] == "joint"]
    better = sorted(here[name] for name in joint if here[name] < here["defaults"])
    assert (len(joint), len(better)) == (64, 5)
    median = np.median([here[name] for name in joint])
    assert f"({better[0]:.3f} to {better[-1]:.3f}; defaults {here['defaults']:.3f}, median {median:.3f})" in page
    behind = [elsewhere[name] - elsewhere["defaults"] for name in order[1:]]
    assert f"by {behind[0]:.3f} to {behind[-1]:.3f}." in page
    agreed = spearmanr([here[name] for name in order], [elsewhere[name] for name in order])
    assert "(rank correlation {:.2f}, p {:.2f})".format(*agreed) in page
    said = re.search(r"packets \(rank correlation (.*?)\).*wall \((.*?)\).*strip \((.*?)\).*agents \((.*?)\); "
                     r"path-loss exponent \((.*?)\) and speed \((.*?)\)", page)  # fmt: skip
    assert said is not None
    values = [dict(pair.split("=") for pair in name.split(", ")) for name in joint]
    names = ("swarm.packets", "radio.wall_loss_db", "world.strip_half_width", "swarm.agents",
             "radio.path_loss_exponent", "swarm.speed")  # fmt: skip
    for figure, name in zip(said.groups(), names, strict=True):
        found = spearmanr([float(one[name]) for one in values], [here[one] for one in joint])
        assert numbers(figure) == [round(found.statistic, 2)], name


def test_what_is_said_of_novelty_search_is_that_of_the_runs():
    folder = DOCS / "results" / "novelty"
    with (folder / "contributions_fresh_comparisons.csv").open(encoding="utf-8") as file:
        [row] = csv.DictReader(file)
    figures = {name: float(value) for name, value in row.items() if re.fullmatch(r"-?[\d.e-]+", value)}
    said = (
        f"a difference of {figures['difference']:.3f} (BCa 90 %: {figures['BCa 90 low']:.3f} to "
        f"{figures['BCa 90 high']:.3f})"
    )
    page = (folder / "README.md").read_text(encoding="utf-8")
    assert said in page
    assert (
        f"over the pairs, which share their world and their first solution, has p {figures['Wilcoxon p']:.4f}" in page
    )
    assert f"does not know the pairs, has p {figures['Mann-Whitney p']:.3f}" in page
    with tarfile.open(folder / "runs.tar.xz") as archive:
        runs = [f"urban_jammed_long/seed_{seed}" for seed in range(7000, 7030)]
        pairs = [[fresh_of(archive, f"novelty/{arm}/{run}") for arm in ("slcs2", "ailta")] for run in runs]
        arms = [[rows_of(archive, f"novelty/{arm}/{run}") for run in runs] for arm in ("slcs2", "ailta")]
    assert f"a gain in {sum(mine > its for mine, its in pairs)} of {len(pairs)} instances" in page
    best, spent = (np.array([[[row[field] for row in rows] for rows in arm] for arm in arms]) for field in SPENDING)
    spent = spent.cumsum(axis=2)
    for line in re.findall(r"^\| \d+ \|.*$", page, re.M):
        generation, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        mine, its = best[:, :, int(generation) - 1]
        found = compare(mine, its)
        figures = [mine.mean(), its.mean(), found.difference, *found.bootstrap, found.p_wilcoxon]
        assert [number for cell in (*cells[:3], cells[4]) for number in numbers(cell)] == [round(x, 3) for x in figures]
        assert cells[3] == f"{(mine > its).sum()}, {(mine < its).sum()}"
        assert cells[5] == "{:.0f}, {:.0f}".format(*spent[:, :, int(generation) - 1].mean(axis=1))
    assert "ahead by {:.3f} ({:.3f} to {:.3f}; p {:.3f})".format(*at_equal_episodes(best, spent)) in page


def test_what_is_said_of_the_papers_size_is_that_of_the_runs():
    folder = DOCS / "results" / "full"
    page = (folder / "README.md").read_text(encoding="utf-8")
    means, contests = {}, {}
    for experiment in ("contributions", "designed"):
        with (folder / f"{experiment}_fitness.csv").open(encoding="utf-8") as file:
            means |= {(row["world"], row["arm"]): row for row in csv.DictReader(file)}
        with (folder / f"{experiment}_fresh_comparisons.csv").open(encoding="utf-8") as file:
            contests |= {(row["world"], row["against"]): row for row in csv.DictReader(file)}
    arms = "SLCS2", "no novelty (AILTA)", "no exchange", "designed"
    for marked, rows, shown, columns in (
        ("results", means, arms, ("fresh mean", "best mean")),
        ("comparisons", contests, arms[1:], ("difference", "BCa 90 low", "BCa 90 high")),
    ):
        table = re.search(rf"^<!-- {marked}: .*?-->\n(.*?)^<!-- end", page, re.M | re.S)
        assert table is not None
        for line in table[1].splitlines()[2:]:
            world, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            for arm, cell in zip(shown, cells, strict=True):
                said = numbers(cell)
                assert said == [round(float(rows[world, arm][name]), 3) for name in columns][: len(said)], (world, arm)
    said = re.search(r"in long open \((\S+), p (\S+)\), in both jammed worlds \((\S+) and (\S+), p (\S+) and (\S+)\) "
                     r"and in short urban jammed \((\S+), p (\S+)\)", page)  # fmt: skip
    assert said is not None
    significant = "long open", "short jammed", "long jammed", "short urban jammed"
    shown = [contests[world, "no exchange"] for world in significant]
    figures = [numbers(figure)[0] for figure in said.groups()]
    order = [0, 2, 3, 6, 1, 4, 5, 7]  # differences, then p
    assert [figures[place] for place in order] == [
        round(float(row[name]), 3) for name in ("difference", "Holm p") for row in shown
    ]
    worlds = ("open_short", "jammed_short", "urban_short", "urban_jammed_short", "open_long", "jammed_long")
    runs = [f"{world}/seed_{1000 * place + k:03d}" for place, world in enumerate(worlds) for k in range(10)]
    with tarfile.open(folder / "runs.tar.bz2") as archive:
        fresh, rows = (
            [[read(archive, f"full/{arm}/{run}") for run in runs] for arm in ("slcs2", "ailta", "no_exchange")]
            for read in (fresh_of, rows_of)
        )
    for other, said in (
        (fresh[1], "45 of them (Wilcoxon p 0.00001)"),
        (fresh[2], "56 of them, in all twenty long ones"),
    ):
        found = compare(*map(np.array, (fresh[0], other)))
        assert found.bootstrap is not None
        overall = "{:.3f} ({:.3f} to {:.3f}".format(found.difference, *found.bootstrap)
        assert f"over the sixty pairs by {overall}), ahead in {said}" in page
        assert overall in text("results/index.md").replace("there (", "(").replace("of rule exchange (", "(")
        assert sum(mine > its for mine, its in zip(fresh[0], other, strict=True)) == int(said[:2])
        assert found.p_wilcoxon < 0.000015
    assert all(mine > its for mine, its in zip(fresh[0][40:], fresh[2][40:], strict=True))
    best, spent = (np.array([[[row[name] for row in one] for one in arm] for arm in rows[:2]]) for name in SPENDING)
    ahead = [(best[0] - best[1])[:, mark - 1].mean() for mark in (200, 500)]
    assert "the difference is {:.3f} after 200 generations and {:.3f} after 500".format(*ahead) in page
    found = at_equal_episodes(best, spent.cumsum(axis=2))
    assert "by {:.3f} over the sixty pairs ({:.3f} to {:.3f}; p {:.4f})".format(*found) in page


def test_what_is_said_of_two_thousand_generations_is_that_of_the_runs():
    page = text("results/paper/README.md")
    shown = re.search(r"^<!-- two thousand.*?-->\n(.*?)^<!-- end -->", page, re.M | re.S)
    assert shown is not None
    marks, best, episodes = (
        [float(cell) for cell in line.strip("|").split("|")[1:]]
        for line in (shown[1].splitlines()[row] for row in (0, 2, 3))
    )
    with (
        tarfile.open(DOCS / "results" / "paper" / "two_thousand_open_short.tar.xz") as long,
        tarfile.open(DOCS / "results" / "full" / "runs.tar.bz2") as short,
    ):
        runs = [f"slcs2/open_short/seed_{seed:03d}" for seed in range(8)]
        searches = [rows_of(long, f"two_thousand/{run}") for run in runs]
        earlier = [rows_of(short, f"full/{run}") for run in runs]
        fresh = [
            np.array([fresh_of(archive, f"{root}/{run}") for run in runs])
            for archive, root in ((long, "two_thousand"), (short, "full"))
        ]
    again, before = (  # without what the second archive has left out
        [
            [{name: row[name] for name in row.keys() - {"contribution", "crc"}} for row in rows[:500]]
            for rows in searched
        ]
        for searched in (searches, earlier)
    )
    assert again == before  # of another maker's processor
    spent = np.cumsum([[row["deployments"] for row in rows] for rows in searches], axis=1)
    for mark, figure, count in zip(marks, best, episodes, strict=True):
        at = int(mark) - 1
        assert figure == round(np.mean([rows[at]["best"] for rows in searches]), 3)
        assert count == round(spent[:, at].mean())
    found = compare(*fresh)
    assert f"come to {fresh[0].mean():.3f} after 2000 generations and to {fresh[1].mean():.3f} after 500" in page
    assert found.bootstrap is not None
    told = (found.difference, *found.bootstrap, found.p_mann_whitney, found.p_wilcoxon)
    assert (
        "a difference of {:.3f} (BCa 90 %: {:.3f} to {:.3f}; Mann–Whitney p {:.3f}, Wilcoxon {:.3f})".format(*told)
        in page
    )


def test_the_rules_in_words_are_those_of_the_solution_that_is_there():
    solution = load_solution(DOCS / "results" / "paper" / "winner_long_urban_seed_003.npz")
    [block] = [block.text for block in blocks(DOCS / "howto" / "read_run.md") if "most often" in block.text]
    shown = re.findall(r"^ *([\d.]+) +([\d.]+) +([\d.]+) +(\d+) +\d+ +\d+  (.*)  \[(.*)\]$", block, re.MULTILINE)
    lines = [line for line in rule_lines(solution) if line.agent == 7]
    assert len(shown) == 2
    for said, line in zip(shown, lines, strict=False):
        figures = f"{line.quality:.2f}", f"{line.strength:.4f}", f"{line.error:.2f}", str(line.usage)
        assert said == (*figures, line.rule, line.origin)


def test_every_field_of_a_row_is_explained():
    page = text("howto/read_run.md")
    table = page[page.index("Fields of a row") :]
    for field in ("instance", "seed", *(field.name for field in fields(HistoryRow))):
        assert f"`{field}`" in table, field


def test_the_changelog_begins_with_this_version_and_has_the_usual_headings():
    said = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## (.*)$", said, re.MULTILINE)
    assert re.fullmatch(rf"{re.escape(slcs2_jax.__version__)} - \d{{4}}-\d\d-\d\d", versions[0])
    usual = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
    assert set(re.findall(r"^### (.*)$", said, re.MULTILINE)) <= usual


def test_what_the_source_refers_to_is_shipped():
    sections = {int(number) for number in re.findall(r"^## (\d+)\.", text("model.md"), re.MULTILINE)}
    for room in ("slcs2_jax", "hydra_plugins", "benchmarks", "tests", "examples", "scripts"):
        for path in sorted((ROOT / room).rglob("*.py")):
            said = path.read_text(encoding="utf-8")
            cited = {int(number) for number in re.findall(r"\b[Mm]odel (?:section )?(\d+)(?:\.\d+)?\b", said)}
            assert cited <= sections, path
            pages = set(re.findall(r"\bdocs/[\w/]+\.\w+", said))
            assert [page for page in pages if not (ROOT / page).exists()] == [], path
            assert not re.search(r"§|\bspec(?:ification)?, section|\bthe spec\b", said) or path == Path(__file__), path


def told(path: Path) -> tuple[list[str], list[float]]:
    """What a file says but for its numbers with a point, and those: their last digit is the processor's."""
    number = r"-?\b\d+\.\d+(?:e-?\d+)?\b"
    said = path.read_text(encoding="utf-8")
    return re.split(number, said), [float(one) for one in re.findall(number, said)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("folder", "least"),
    [
        ("paper", None),  # all that is made
        ("novelty", {"contributions_fresh_comparisons.csv", "contributions_fitness.csv"}),
        ("sensitivity", {"sweep_fresh_robustness.csv", "sweep_fresh_responses.csv"}),
        ("full", {f"{name}_fresh_comparisons.csv" for name in ("contributions", "designed")} | {"verdicts.md"}),
    ],
)
def test_the_report_on_the_runs_that_are_here_has_the_tables_that_are_here(folder, least, tmp_path):
    kept = DOCS / "results" / folder
    [runs] = kept.glob("runs.tar.*")
    with tarfile.open(runs) as archive:
        archive.extractall(tmp_path / "runs", filter="data")
    command = [sys.executable, "-m", "slcs2_jax", "report", f"runs/{folder}", "replays=0"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    made = tmp_path / "runs" / folder / "report"
    suffixes = (".csv", ".json", ".md", ".tex")
    names = {path.name for path in kept.iterdir() if path.suffix in suffixes} - {"README.md"}
    assert (least or {path.name for path in made.iterdir() if path.suffix in suffixes}) <= names
    for name in names:
        (said, figures), (kept_said, kept_figures) = map(told, (made / name, kept / name))
        assert said == kept_said, name
        assert figures == pytest.approx(kept_figures, rel=1e-12, abs=0), name


def test_scripts_and_examples_that_are_named_exist():
    for page in (README, *PAGES):
        said = page.read_text(encoding="utf-8")
        for path in set(re.findall(r"\b((?:scripts|examples)/\w+(?:\.py)?)", said)):
            assert (ROOT / path).is_file(), (page.name, path)
