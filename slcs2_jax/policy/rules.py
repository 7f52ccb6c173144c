"""Compiled rules: the parameters of policies that are made of them."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import numpy as np

from slcs2_jax.grammar import RuleSets
from slcs2_jax.grammar.language import Language


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Rules:
    """W words, R rules, n agents.

    Attributes:
        mask: uint32 [W, R, n, ...], clauses.
        action: uint8 [R, n, ...].
        reflex: bool [R, n, ...], rules that act whenever they hold; None where there are none.
        quality: float32 [R, n, ...], q at the start; None for that of the settings.
    """

    mask: Any
    action: Any
    reflex: Any = None
    quality: Any = None

    @classmethod
    def of(cls, rules: RuleSets, language: Language) -> Rules:
        """Rule-sets as NumPy arrays laid out for the device, with as many words as the language needs."""
        reflex, quality = (None if one is None else one.T for one in (rules.reflex, rules.quality))
        return cls(rules.mask.transpose(2, 1, 0)[: language.words], rules.action.T, reflex, quality)

    @classmethod
    def like(cls, rules: int, agents: int, language: Language) -> Rules:
        """Arrays of these sizes, all zero."""
        return cls(np.zeros((language.words, rules, agents), np.uint32), np.zeros((rules, agents), np.uint8))
