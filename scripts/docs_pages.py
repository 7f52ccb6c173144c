"""Pages of the documentation that are made when it is built (`mkdocs build`): the Python reference, the settings, the
table of assumed values of the model, the notebooks.
"""

from __future__ import annotations

import csv
import sys
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import slcs2_jax
from slcs2_jax.config.field import accepted, described, show
from slcs2_jax.config.table import reference_markdown, settings_table
from slcs2_jax.learning.ippo_settings import Ippo
from slcs2_jax.learning.network_settings import NetworkSettings
from slcs2_jax.learning.strategy_settings import Strategy

sys.path.append(str(Path(__file__).resolve().parent))
from docs_notebooks import notebook_files

if TYPE_CHECKING:
    from mkdocs.structure.files import Files

ROOT = Path(__file__).resolve().parent.parent
CALIBRATION = ROOT / "docs" / "results" / "calibration" / "calibration.csv"
ASSUMED = "<!-- assumed values -->"  # where the table stands in docs/model.md
LEARNING = {  # where their tables stand in docs/howto/train_network.md
    "<!-- settings of IPPO -->": Ippo,
    "<!-- settings of the strategy -->": Strategy,
    "<!-- settings of the network -->": NetworkSettings,
}

# Sections of the Python reference: what each is for, and the modules whose public names it has.
SECTIONS = {
    "Evolve, evaluate, look": ("slcs2_jax.api", "slcs2_jax.running.evaluator", "slcs2_jax.looking.solutions"),
    "The environment": ("slcs2_jax.env",),
    "Settings": ("slcs2_jax.config", "slcs2_jax.config.chosen"),
    "Worlds": ("slcs2_jax.world.scenario",),
    "Rules": ("slcs2_jax.grammar",),
    "Policies": (
        "slcs2_jax.policy.policy",
        "slcs2_jax.policy.network",
        "slcs2_jax.policy.bound",
        "slcs2_jax.policy.decision_list",
    ),
    "Parts of your own": ("slcs2_jax.config.registry", "slcs2_jax.swarm.intent", "slcs2_jax.swarm.task"),
    "What runs leave behind": ("slcs2_jax.results",),
}
# What the public names return or ask for.
BESIDE = {
    "The environment": ("slcs2_jax.env.Params", "slcs2_jax.env.Seen", "slcs2_jax.env.Spaces"),
    "Evolve, evaluate, look": (
        "slcs2_jax.running.evaluator.Evaluations",
        "slcs2_jax.search.evaluation.Deployment",
        "slcs2_jax.looking.recording.Recording",
    ),
    "Networks": (
        "slcs2_jax.learning.ippo.train",
        "slcs2_jax.learning.evolution_strategy.train",
        "slcs2_jax.learning.algorithms",
    ),
    "What runs leave behind": ("slcs2_jax.results.reading.FinishedRun", "slcs2_jax.results.summary.RunSummary"),
    "Parts of your own": (
        "slcs2_jax.swarm.view.View",
        "slcs2_jax.swarm.reward.Reward",
        "slcs2_jax.world.fading.Fading",
        "slcs2_jax.world.propagation.Propagation",
        "slcs2_jax.world.emission.Listening",
        "slcs2_jax.world.jammer_motion.Wandering",
    ),
    "A search": (
        "slcs2_jax.search.protocol.Search",
        "slcs2_jax.search.base.BaseSearch",
        "slcs2_jax.search.problem.Problem",
        "slcs2_jax.search.solution.Solution",
        "slcs2_jax.search.parts",
    ),
    "Learners' interfaces": ("slcs2_jax.adapters.pettingzoo.Parallel", "slcs2_jax.adapters.jaxmarl.JaxMARL"),
}


def on_files(files: Files, config: Any) -> Files:
    """MkDocs asks for the files: add those that are made."""
    from mkdocs.structure.files import File

    made = {"reference/api.md": api_markdown(), "reference/settings.md": reference_markdown(), **notebook_files()}
    for path, content in made.items():
        files.append(File.generated(config, path, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """MkDocs asks for the text of a page: put tables where they belong."""
    if page.file.src_path == "model.md":
        return markdown.replace(ASSUMED, assumed_markdown())
    if page.file.src_path == "howto/train_network.md":
        for place, section in LEARNING.items():
            markdown = markdown.replace(place, section_markdown(section))
    return markdown


def api_markdown() -> str:
    """The page of all public names, by section."""
    known = defaultdict(list)
    for name in slcs2_jax.__all__:
        if name in slcs2_jax._HOME:
            known[slcs2_jax._HOME[name]].append(name)
    lines = [
        "# Python reference",
        "",
        "`import slcs2_jax as slcs2` has every name of which this page does not say where else it lives. Arrays are",
        "given with their shapes: n agents, R rules, T time-steps; `...` is a batch, the last axis, or none. Lengths",
        "are in m, levels in dBm, times in time-steps.",
    ]
    for section in {**SECTIONS, **BESIDE}:
        lines += ["", f"## {section}"]
        for home in SECTIONS.get(section, ()):
            for name in known.pop(home):
                lines += ["", f"::: {defined(name)}"]
        for place in BESIDE.get(section, ()):
            lines += ["", f"::: {place}", "    options:", "      show_root_full_path: true"]
    if known:
        raise ValueError(f"scripts/docs_pages.py: no section has the names of {sorted(known)}")
    return "\n".join(lines) + "\n"


def defined(name: str) -> str:
    """Where a public name is defined, for mkdocstrings, which reads the source."""
    part = getattr(slcs2_jax, name)
    return f"{part.__module__}.{name}"


def assumed_markdown() -> str:
    """All values that the paper does not print, each with its reason, and how the misfit moves with it."""
    moves = sensitivity()
    lines = [
        "| setting | value | unit | status | what it is | why this value | other values: misfit |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in settings_table():
        if row.status in ("assumed", "calibrated"):
            cells = row.help, row.reason or "–", moves.get(row.name, "not varied")
            texts = " | ".join(cell.replace("|", "\\|") for cell in cells)
            lines.append(f"| `{row.name}` | {row.value} | {row.unit or '–'} | {row.status} | {texts} |")
    return "\n".join(lines)


def section_markdown(section: type) -> str:
    """The settings of a section that is none of a run's."""
    lines = ["| setting | default | unit | accepted | what it is |", "|---|---|---|---|---|"]
    for field in described(section):
        cells = (f"`{field.name}`", show(field.default), field.doc.unit or "–", accepted(field), field.doc.help)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def sensitivity() -> dict[str, str]:
    """Of each setting that the calibration study varied alone: its other values with their misfit."""
    found: dict[str, list[str]] = defaultdict(list)
    with CALIBRATION.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["tried"] == "level":
                name, _, value = row["settings"].partition("=")
                found[name].append(f"{value}: {float(row['misfit']):.3f}")
    return {name: ", ".join(values) for name, values in found.items()}
