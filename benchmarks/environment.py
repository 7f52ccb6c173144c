"""The environment alone: steps per second under a random policy against batch size, compiling apart."""

from __future__ import annotations

import argparse
import math
import sys
import time
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from benchmarks.options import CELLS, Parser, choice, listed, whole
from benchmarks.report import Report, figure, markdown
from benchmarks.rounds import Play, Spread, interleave
from slcs2_jax.config import Compute
from slcs2_jax.env import Env, EnvState, Params, Seen, make

MOST_STEPS = 2000
NOTES = """\
A stretch is one call of a compiled program: `lax.scan` over steps of `vmap(env.step)`, every agent taking any of the
actions that could have an effect, all alike; all of the observation is used. Only steps of running episodes count, and
nothing is reset. Each figure is the median of the stretches, with the least and the greatest, every result waited for;
sizes take turns. Compiling is tracing and compiling the program, without a cache on disk. One device; on CPUs XLA
shares a kernel out to the cores as it likes.
"""


def main(arguments: list[str] | None = None) -> int:
    """Measure what the command line asks for, print, and save."""
    parser = Parser("environment", __doc__)
    add = parser.add_argument
    add("--cells", type=listed(choice(*CELLS)), default=("open/short", "urban/short"), metavar="KIND/RANGE,...",
        help=f"worlds; of {', '.join(CELLS)}")  # fmt: skip
    add("--batch", type=listed(whole(1, 10**6)), default=(1, 16, 256, 4096), metavar="N,...", help="episodes at once")
    add("--work", type=whole(1, 10**9), default=40_000, help="environment steps of a stretch, about")
    add("--repeats", type=whole(1, 1000), default=5, help="stretches of each size")
    add("--agents", type=whole(2, 64), default=12, help="agents")
    return parser.run(partial(measure, parser), arguments)


def measure(command_line: Parser, options: argparse.Namespace) -> None:
    """Measure every world, print as it goes, save at the end."""
    command_line.check_folders(options.json)
    report = Report("environment", options.command, Compute(devices=1), NOTES)
    print(report.heading())
    for cell in options.cells:
        env = make(cell.replace("/", "_"), {"swarm.agents": options.agents})
        rows = measure_cell(env, options)
        report.add(cell, rows)
        print(f"### {cell}\n\n{_table(rows)}", flush=True)
    print(report.notes())
    report.save(options.json)


def measure_cell(env: Env, options: argparse.Namespace) -> list[dict[str, Any]]:
    """A row for every batch size."""
    stretches = {str(size): Stretch(env, size, steps_of(size, options.work)) for size in options.batch}
    plays = interleave({name: stretch.play for name, stretch in stretches.items()}, options.repeats)
    return [
        {
            "batch": int(name),
            "steps": stretch.steps,
            "compile_seconds": stretch.compile_seconds,
            "env_steps_per_second": Spread.of([play.rate for play in plays[name]]).as_dict(),
            "agent_steps_per_second": Spread.of([play.rate * env.agents for play in plays[name]]).as_dict(),
        }
        for name, stretch in stretches.items()
    ]


def steps_of(batch: int, work: int) -> int:
    """Steps of a stretch, so that all sizes do about as much work."""
    return min(max(10, math.ceil(work / batch)), MOST_STEPS)


class Stretch:
    """So many episodes under way, and the compiled program that takes them some steps further."""

    def __init__(self, env: Env, batch: int, steps: int) -> None:
        self.steps, self._batch, self._params = steps, batch, env.params
        keys = jax.random.split(jax.random.key(0), batch)
        self._key = jax.random.key(1)
        self._episodes = jax.block_until_ready(jax.jit(jax.vmap(env.reset, (0, None)))(keys, env.params))
        start = time.perf_counter()
        program = jax.jit(partial(advance, env, steps))
        self._program = program.lower(*self._episodes, self._key, env.params).compile()
        self.compile_seconds = time.perf_counter() - start
        self.play()  # the first call of a program is slower

    def play(self) -> Play:
        """Measure one call."""
        self._key, key = jax.block_until_ready(jax.random.split(self._key))
        start = time.perf_counter()
        *episodes, running, _ = jax.block_until_ready(self._program(*self._episodes, key, self._params))
        seconds = time.perf_counter() - start
        self._episodes = tuple(episodes)
        return Play(seconds, int(running), self._batch * self.steps, ())


def advance(
    env: Env, steps: int, seen: Seen, state: EnvState, key: jax.Array, params: Params
) -> tuple[Seen, EnvState, jax.Array, jax.Array]:
    """Some steps of random actions: what is seen, the state, how many steps were made, a sum of all that was seen."""

    def one(carry: Any, key: jax.Array) -> tuple[Any, jax.Array]:
        seen, state = carry
        action = random_action(key, seen.action_mask)
        seen, state, reward, *_ = jax.vmap(env.step, (None, 0, 0, None))(key, state, action, params)
        return (seen, state), jnp.sum(seen.features) + jnp.sum(seen.clauses, dtype=jnp.float32) + jnp.sum(reward)

    (seen, after), used = jax.lax.scan(one, (seen, state), jax.random.split(key, steps))
    return seen, after, jnp.sum(after.swarm.t - state.swarm.t), jnp.sum(used)


def random_action(key: jax.Array, mask: jax.Array) -> jax.Array:
    """Any of the actions that the mask (bool [..., A]) allows: int32 [...]."""
    rank = jnp.cumsum(mask, axis=-1, dtype=jnp.int32)
    lot = jax.random.uniform(key, rank.shape[:-1]) * rank[..., -1].astype(jnp.float32)
    return jnp.argmax(rank > lot.astype(jnp.int32)[..., None], axis=-1).astype(jnp.int32)


def _table(rows: list[dict[str, Any]]) -> str:
    shown = []
    for row in rows:
        rate = row["env_steps_per_second"]
        shown.append(
            [
                str(row["batch"]),
                f"{figure(rate['median'])} ({figure(rate['low'])}–{figure(rate['high'])})",
                figure(row["agent_steps_per_second"]["median"]),
                figure(row["compile_seconds"]),
            ]
        )
    return markdown(["episodes at once", "env-steps/s", "agent-steps/s", "compiling, s"], shown)


if __name__ == "__main__":
    sys.exit(main())
