"""Successive halving among finalists (Karnin, Koren and Somekh 2013), so that a winner is chosen by enough deployments.

A final has F finalists, F a power of two: the fittest of those held. In each round all that are left are deployed
again, each a generation of its own, and the fitter half of them by all of its deployments goes on, down to a round of
two. A final is the last 2 F - 2 of every `search.final_every` generations, so that a run that goes further is as one
that went so far at once. Where `search.episodes` ends a search there is one final, as soon as what is left of them is
what it takes.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Schedule:
    """Which generations are finals'."""

    finalists: int
    every: int

    @property
    def length(self) -> int:
        """Generations of a final."""
        return 2 * self.finalists - 2

    @property
    def first(self) -> int:
        """Place of a final's first generation within a period."""
        return self.every - self.length

    def turn(self, generation: int) -> tuple[int, int] | None:
        """(finalists left in this round, this one's turn in it) for a generation of a final; None for any other."""
        turn = generation % self.every - self.first
        return None if turn < 0 else self.round_of(turn)

    def round_of(self, turn: int) -> tuple[int, int]:
        """(finalists left in its round, its turn in it) of a final's generation `turn`, from 0."""
        left = self.finalists
        while turn >= left:
            turn -= left
            left //= 2
        return left, turn

    def stop(self, generation: int) -> int:
        """The generation behind those that can be asked for together with this one: up to the next round's first."""
        turn = self.turn(generation)
        if turn is None:
            return generation - generation % self.every + self.first
        return generation + turn[0] - turn[1]
