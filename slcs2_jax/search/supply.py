"""Random rules for one run, drawn in blocks: in bulk, decoding costs a quarter of what a few hundred at a time do."""

from __future__ import annotations

from collections.abc import Set
from typing import Any, Protocol

import numpy as np

from slcs2_jax.config import InputError
from slcs2_jax.config.field import refuse
from slcs2_jax.grammar.ruleset import rule_ids

BLOCK = 4096  # part of what a seed means: another size gives other rules
_MOST_BLOCKS = 100  # drawn in search of one agent's rules; a grammar with enough of them takes less than one


class RuleSource(Protocol):
    """Draws `count` random rules: clause masks uint32[count, 4] and actions uint8[count]."""

    def __call__(self, count: int, rng: np.random.Generator, /) -> tuple[np.ndarray, np.ndarray]: ...


class RuleSupply:
    """An endless sequence of random rules that follows from a seed sequence alone, however it is cut up in taking."""

    def __init__(self, source: RuleSource, seeds: np.random.SeedSequence) -> None:
        self._source = source
        self._rng = np.random.Generator(np.random.PCG64(seeds))
        self._before = self._rng.bit_generator.state  # of the generator when the present block was drawn
        self._block: dict[str, np.ndarray] | None = None  # drawn when first needed
        self._used = 0  # rules of it that were taken

    def _draw(self) -> dict[str, np.ndarray]:
        self._before = self._rng.bit_generator.state
        mask, action = self._source(BLOCK, self._rng)
        if mask.ndim != 2 or len(mask) != BLOCK or action.shape != (BLOCK,):
            raise InputError(
                f"rule source returned masks {mask.shape} and actions {action.shape} for {BLOCK} rules; "
                f"({BLOCK}, words) and ({BLOCK},) are expected"
            )
        mask, action = np.asarray(mask, np.uint32), np.asarray(action, np.uint8)
        return {"mask": mask, "action": action}

    def take(self, count: int) -> dict[str, np.ndarray]:
        """The next `count` rules: mask uint32[count, 4], action uint8[count]."""
        pieces: list[dict[str, np.ndarray]] = []
        while count or not pieces:
            if self._block is None:
                self._block = self._draw()
            piece = slice(self._used, min(BLOCK, self._used + count))
            pieces.append({name: array[piece] for name, array in self._block.items()})
            count -= piece.stop - piece.start
            self._used = piece.stop
            if self._used == BLOCK:
                self._block, self._used, self._before = None, 0, self._rng.bit_generator.state
        return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}

    def take_distinct(self, count: int, others: Set[int] = frozenset()) -> dict[str, np.ndarray]:
        """The next `count` rules of which none is twice, nor among the identities of `others`; the rest are dropped.

        Raises InputError if the grammar has too few different rules.
        """
        seen, pieces = set(others), [self.take(0)]
        missing, blocks = count, 0
        while missing:
            drawn = self.take(missing)
            new = []
            for place, one in enumerate(rule_ids(drawn["mask"], drawn["action"]).tolist()):
                if one not in seen:
                    seen.add(one)
                    new.append(place)
            pieces.append({name: array[new] for name, array in drawn.items()})
            missing, blocks = missing - len(new), blocks + 1
            if blocks > _MOST_BLOCKS * max(1, BLOCK // max(1, count)):
                raise refuse("rules.distinct", True, f"a grammar with at least {count} different rules that can hold")
        return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}

    def state(self) -> dict[str, Any]:
        """Where in the sequence the supply stands, JSON-able."""
        return {"before": self._before, "used": self._used}

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from where state() was taken."""
        self._rng.bit_generator.state = state["before"]
        self._before, self._used, self._block = state["before"], int(state["used"]), None
