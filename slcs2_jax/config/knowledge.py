"""What a designer knows, given to a search: settings (docs/howto/informed.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slcs2_jax.config.field import Section, setting


@dataclass(frozen=True)
class Knowledge(Section):
    """A decision list in the first places of every rule-set; none of it is the paper's (docs/howto/informed.md)."""

    SECTION: ClassVar[str] = "knowledge"

    mode: str = setting(
        "none",
        "the designer's rules in a search: none, suggested (rules as any other), or reflex (flagged ones act before "
        "any choice); set by knowledge=",
        status="definition",
        options=("none", "suggested", "reflex"),
    )
    rules: str = setting("designed", "the rules: designed, or the path of a decision list", status="definition")
    start: str = setting(
        "both",
        "which rules are reflexes at first: those about packets, all, or by turns",
        status="definition",
        options=("packets", "all", "both"),
    )
    alone: float = setting(
        0.5,
        "share of children in which nothing but flags changes",
        reason="half, untuned",
        low=0,
        high=1,
    )
