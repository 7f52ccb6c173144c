"""Draws the towns of the benchmark suite's worlds from files: python scripts/suite_worlds.py FOLDER

The files in slcs2_jax/suite/v1/worlds were drawn so once, and are what counts; this says how.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

LAYOUTS = 9
DISTANCE, CLEAR, HALF = 600, 60, 130  # m: source to sink; around both no wall stands; half the town's width
SINK = f"sink: [{DISTANCE}, 0]\n"


def rectangle(x: int, y: int, length: int, width: int) -> str:
    """A block with four walls."""
    return f"  - {{corner: [{x}, {y}], opposite: [{x + length}, {y + width}]}}\n"


def segment(x1: int, y1: int, x2: int, y2: int) -> str:
    """A wall."""
    return f"  - {{from: [{x1}, {y1}], to: [{x2}, {y2}]}}\n"


def manhattan(rng: np.random.Generator) -> str:
    """Closed blocks of 25 to 60 m between streets of 12 to 20 m; a street runs from source to sink."""
    lines = ["# A Manhattan: closed blocks in rows, streets between them; lengths in m\n", SINK, "walls:\n"]
    rows: list[tuple[int, int]] = []
    for side in (1, -1):
        edge = int(rng.integers(6, 11))
        while edge < HALF:
            depth = int(rng.integers(25, 61))
            rows.append((edge if side > 0 else -edge - depth, depth))
            edge += depth + int(rng.integers(12, 21))
    x = CLEAR
    while True:
        length = int(rng.integers(25, 61))
        if x + length > DISTANCE - CLEAR:
            return "".join(lines)
        lines += [rectangle(x, y, length, depth) for y, depth in rows]
        x += length + int(rng.integers(12, 21))


def house(x: int, y: int, length: int, width: int, rng: np.random.Generator) -> list[str]:
    """Four walls with a door of 6 m in one or two of them, and in every other house a wall inside."""
    lines = []
    doors = set(rng.permutation(4)[: int(rng.integers(1, 3))].tolist())
    corners = [(x, y), (x + length, y), (x + length, y + width), (x, y + width)]
    for side in range(4):
        (x1, y1), (x2, y2) = sorted((corners[side], corners[(side + 1) % 4]))
        if side not in doors:
            lines.append(segment(x1, y1, x2, y2))
            continue
        along = (x2 - x1) + (y2 - y1)
        at = int(rng.integers(2, along - 7))
        dx, dy = (1, 0) if x2 > x1 else (0, 1)
        lines.append(segment(x1, y1, x1 + dx * at, y1 + dy * at))
        lines.append(segment(x1 + dx * (at + 6), y1 + dy * (at + 6), x2, y2))
    if rng.random() < 0.5:
        middle = x + length // 2
        lines.append(segment(middle, y, middle, y + width // 2))
    return lines


def houses(rng: np.random.Generator) -> str:
    """Some 45 houses of all sizes anywhere, none across another, with doors."""
    lines = ["# A town of irregular houses with doors; lengths in m\n", SINK, "walls:\n"]
    built: list[tuple[int, int, int, int]] = []
    for _ in range(4000):
        length, width = (int(value) for value in rng.integers(12, 42, 2))
        x = int(rng.integers(CLEAR, DISTANCE - CLEAR - length))
        y = int(rng.integers(-HALF, HALF - width))
        apart = 7
        if len(built) < 45 and all(
            x > a + c + apart or a > x + length + apart or y > b + d + apart or b > y + width + apart
            for a, b, c, d in built
        ):
            built.append((x, y, length, width))
            lines += house(x, y, length, width, rng)
    return "".join(lines)


def main(folder: Path) -> None:
    """Write all layouts of both towns."""
    for number, draw in enumerate((manhattan, houses)):
        for layout in range(LAYOUTS):
            text = draw(np.random.default_rng([20261126, number, layout]))
            (folder / f"{draw.__name__}_{layout}.yaml").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
