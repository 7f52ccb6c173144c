"""Tables: the same rows as CSV, Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from tabulate import tabulate

from slcs2_jax.config import escape
from slcs2_jax.results.arm import OVERALL, arm_title
from slcs2_jax.results.csv_text import csv_text
from slcs2_jax.study.collect import Outcome
from slcs2_jax.study.paper import printed_mean
from slcs2_jax.study.statistics import Interval, share_interval
from slcs2_jax.study.study import BEST, FRESH, METRICS, Study

Row = tuple[object, ...]


@dataclass(frozen=True)
class Table:
    """Rows under a header. Floats and intervals are rounded when printed, and whole in CSV."""

    title: str
    header: tuple[str, ...]
    rows: tuple[Row, ...]

    def printed(self) -> list[list[str]]:
        """The rows as a person reads them."""
        return [[_cell(value) for value in row] for row in self.rows]

    def markdown(self) -> str:
        """A pipe table under its title."""
        rows = [[escape.markdown(value) for value in row] for row in self.printed()]
        header = [escape.markdown(name) for name in self.header]
        table = tabulate(rows, header, tablefmt="pipe", disable_numparse=True)
        return f"**{escape.markdown(self.title)}**\n\n{table}\n"

    def latex(self) -> str:
        """A table with booktabs' rules, as wide as the text (graphicx), for \\input."""
        rows = [" & ".join(escape.latex(value) for value in row) for row in (self.header, *self.printed())]
        head, *body = (f" {row} \\\\" for row in rows)
        columns = "l" * len(self.header)
        lines = [f"\\begin{{tabular}}{{{columns}}}", r"\toprule", head, r"\midrule", *body, r"\bottomrule"]
        inner = "\n".join([*lines, r"\end{tabular}"])
        wide = f"\\resizebox{{\\linewidth}}{{!}}{{%\n{inner}%\n}}"
        title = escape.latex(self.title)
        return f"\\begin{{table}}\n\\centering\n\\caption{{{title}}}\n{wide}\n\\end{{table}}\n"

    def csv(self) -> str:
        """Comma-separated; an interval fills two columns, low and high; what is not known is empty: see `csv_text`."""
        wide = {at for row in self.rows for at, value in enumerate(row) if isinstance(value, Interval)}
        header: list[str] = []
        for at, name in enumerate(self.header):
            header += (f"{name} low", f"{name} high") if at in wide else (name,)
        flat: list[list[object]] = []
        for row in self.rows:
            flat.append([])
            for at, value in enumerate(row):
                flat[-1] += [value] if at not in wide else list(value) if isinstance(value, Interval) else ["", ""]
        return csv_text(header, flat)


def runs_table(outcomes: Sequence[Outcome], root: Path) -> Table:
    """One row for each instance of each run below a folder: tidy data."""
    header = (
        "arm", "environment", "range", "seed", "generations", "generations planned", "best fitness", "fresh mean",
        "deployments", "evaluations", "env-steps", "folder",
    )  # fmt: skip
    rows = []
    for one in outcomes:
        done = len(one.curve)
        rows.append((
            one.arm, one.cell.environment, one.cell.range, one.seed, done, one.planned, one.best(done),
            one.fresh_after(done), len(one.deployments), one.evaluations, one.env_steps,
            str(one.folder.relative_to(root)),
        ))  # fmt: skip
    return Table("Every run", header, tuple(rows))


def descriptions_table(study: Study) -> Table:
    """Every arm in every place, by both metrics, with what the paper prints."""
    header = (
        "world", "arm", "best n", "best mean", "best SD", "best CI90", "best BCa 90", "best > 0", "fresh n",
        "fresh mean", "fresh SD", "fresh CI90", "fresh > 0", "paper",
    )  # fmt: skip
    rows: list[Row] = []
    fresh = study.descriptions(FRESH)
    for (arm, place), one in study.descriptions(BEST).items():
        other = fresh.get((arm, place))
        beside: Row = (0, None, None, None, None)
        if other is not None:
            beside = (other.count, other.mean, other.sd, other.interval, other.successful)
        rows.append((
            place.title, arm_title(arm), one.count, one.mean, one.sd, one.interval, one.bootstrap, one.successful,
            *beside, printed_mean(study.name, arm, place.name),
        ))  # fmt: skip
    return Table(f"{study.title}: fitness {study.when}", header, tuple(rows))


def comparisons_table(study: Study, metric: str) -> Table:
    """The reference against every other arm in every place."""
    header = (
        "world", "against", "n", "difference", "BCa 90", "Mann-Whitney p", "Holm p", "Wilcoxon p", "A12", "A12 CI90",
        "visible", "superior (the paper's rule)",
    )  # fmt: skip
    rows: list[Row] = []
    for (arm, place), one in study.comparisons(metric).items():
        winner = study.reference if one.difference > 0 else arm
        superior = (
            "neither"
            if one.difference == 0
            else f"{arm_title(winner)}, {'' if one.significant else 'non-'}significantly"
        )
        rows.append((
            place.title, arm_title(arm), one.count, one.difference, one.bootstrap, one.p_mann_whitney, one.p_holm,
            one.p_wilcoxon, one.a12, one.a12_interval, one.visible, superior,
        ))  # fmt: skip
    title = f"{study.title}: {arm_title(study.reference)} less the other arm, {METRICS[metric]}"
    return Table(title, header, tuple(rows))


def failures_table(study: Study) -> Table:
    """In how many instances nothing is delivered, by both metrics; counted in the same way for every arm."""
    rows: list[Row] = []
    for arm, place in study.descriptions(BEST):
        single = None if place.environment == OVERALL else study.failed_deployments(arm, place)
        failed = (_failed(study.instances(arm, place, metric)) for metric in (BEST, FRESH))
        rows.append((place.title, arm_title(arm), *chain(*failed), single))
    header = (
        "world", "arm", "best n", "failed by best", "Wilson 90", "fresh n", "failed by fresh", "fresh Wilson 90",
        "failed single deployments",
    )  # fmt: skip
    return Table(f"{study.title}: failures {study.when}", header, tuple(rows))


def _failed(instances: Sequence[tuple[int, float]]) -> Row:
    """Instances, the share of them that deliver nothing, and its interval."""
    if not instances:
        return 0, None, None
    count, delivering = len(instances), sum(figure > -1 for _, figure in instances)
    low, high = share_interval(delivering, count)
    return count, 1 - delivering / count, Interval(1 - high, 1 - low)


def _cell(value: object) -> str:
    """As a person reads it: three decimals, a dash for what is not known."""
    if value is None:
        return "-"
    if isinstance(value, Interval):
        return f"[{value.low:.3f}, {value.high:.3f}]"
    return f"{value:.3f}" if isinstance(value, float) else str(value)
