"""Motion: toward, away and orbit, and the clearance that nobody breaks (model section 4)."""

from __future__ import annotations

import functools
import operator

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.grammar.vocabulary import ORBIT, TOWARD
from slcs2_jax.swarm.intent import Intent
from slcs2_jax.swarm.selection import least, take
from slcs2_jax.swarm.state import State, SwarmParameters, lift
from slcs2_jax.world.arena import Arena
from slcs2_jax.world.geometry import Nearest, blocking_wall
from slcs2_jax.world.stored import stored


def proposed_step(state: State, intent: Intent, parameters: SwarmParameters) -> tuple[jax.Array, jax.Array]:
    """The step that each agent would make if nothing were in its way: float32 [n, ...] twice, m.

    Toward stops at the clearance; away takes a whole step; orbit goes counter-clockwise along a chord of the circle
    around the target, so that the radius is kept. At the target itself there is no direction, and no step.
    """
    dx, dy = intent.place_x - state.x, intent.place_y - state.y
    distance = jnp.sqrt(dx * dx + dy * dy)
    possible = intent.moves & intent.place_known & (distance > 0)
    distance = jnp.where(possible, distance, np.float32(1))
    ux, uy = dx / distance, dy / distance
    toward = jnp.clip(distance - parameters.clearance, np.float32(0), parameters.speed)
    along = jnp.where(intent.direction == TOWARD, toward, -parameters.speed)
    # The chord s of a circle of radius d makes an angle with the tangent whose sine is s / 2d.
    chord = jnp.minimum(parameters.speed, 2 * distance)
    inward = chord / (2 * distance)
    ahead = jnp.sqrt(np.float32(1) - inward * inward)
    orbits = intent.direction == ORBIT
    # Counter-clockwise around the target means to the right of someone who faces it.
    step_x = jnp.where(orbits, chord * (inward * ux + ahead * uy), along * ux)
    step_y = jnp.where(orbits, chord * (inward * uy - ahead * ux), along * uy)
    return jnp.where(possible, step_x, np.float32(0)), jnp.where(possible, step_y, np.float32(0))


def resolve(
    state: State, step_x: jax.Array, step_y: jax.Array, arena: Arena, parameters: SwarmParameters
) -> tuple[jax.Array, jax.Array]:
    """New positions after everybody's proposed step: float32 [n, ...] twice, m.

    A proposal that would bring an agent nearer than the clearance (or than it is) to a wall, another's place or
    another's proposal is replaced by its projection on the tangent of the nearest obstacle in its way, if that is
    allowed; else the agent stays. Tangent steps must keep clear of each other, too, so that no two agents ever overlap.
    """
    x, y = state.x, state.y
    to_x, to_y = x + step_x, y + step_y
    obstacle = blocking_wall(x, y, to_x, to_y, parameters.clear, parameters.half_thickness, arena.walls)
    obstacle = _blocking_agent(obstacle, state, to_x, to_y, x, y, parameters)
    obstacle = _blocking_agent(obstacle, state, to_x, to_y, to_x, to_y, parameters)
    refused = jnp.isfinite(obstacle.squared)

    slide_x, slide_y = _tangent(state, step_x, step_y, obstacle)
    side_x, side_y = x + slide_x, y + slide_y
    wall = blocking_wall(x, y, side_x, side_y, parameters.clear, parameters.half_thickness, arena.walls)
    others = ((x, y, True), (to_x, to_y, True), (side_x, side_y, refused[:, None]))
    in_the_way = [_too_near(state, side_x, side_y, x, y, parameters) & counts for x, y, counts in others]
    hindered = jnp.any(stored(functools.reduce(operator.or_, in_the_way), parameters.speed), axis=0)

    slides = refused & ~hindered & jnp.isinf(wall.squared)
    new_x = jnp.where(refused, jnp.where(slides, side_x, x), to_x)
    new_y = jnp.where(refused, jnp.where(slides, side_y, y), to_y)
    return new_x, new_y


def _too_near(
    state: State,
    to_x: jax.Array,
    to_y: jax.Array,
    other_x: jax.Array,
    other_y: jax.Array,
    parameters: SwarmParameters,
) -> jax.Array:
    """Whether a move of self to (to_x, to_y) comes too near to where other is or would be: bool [other, self, ...]."""
    n = state.x.shape[0]
    before = (state.x[:, None] - state.x) ** 2 + (state.y[:, None] - state.y) ** 2
    after = (other_x[:, None] - to_x) ** 2 + (other_y[:, None] - to_y) ** 2
    limit = jnp.minimum(parameters.clear, before)
    return (after < limit) & lift(~np.eye(n, dtype=bool), state.t)


def _blocking_agent(
    best: Nearest,
    state: State,
    to_x: jax.Array,
    to_y: jax.Array,
    other_x: jax.Array,
    other_y: jax.Array,
    parameters: SwarmParameters,
) -> Nearest:
    """Let the nearest agent that forbids the move replace ``best`` where it is nearer, seen from the present place."""
    blocks = _too_near(state, to_x, to_y, other_x, other_y, parameters)
    x, y = (jnp.broadcast_to(a[:, None], blocks.shape) for a in (other_x, other_y))
    index, squared = least(blocks, (x - state.x) ** 2 + (y - state.y) ** 2, parameters.speed)
    return best.or_nearer(squared, take(x, index), take(y, index))


def _tangent(state: State, step_x: jax.Array, step_y: jax.Array, obstacle: Nearest) -> tuple[jax.Array, jax.Array]:
    """The part of a step across the direction to the obstacle; no step if the agent touches it."""
    possible = jnp.isfinite(obstacle.squared) & (obstacle.squared > 0)
    distance = jnp.sqrt(jnp.where(possible, obstacle.squared, np.float32(1)))
    nx, ny = (obstacle.x - state.x) / distance, (obstacle.y - state.y) / distance
    into = step_x * nx + step_y * ny
    slide_x, slide_y = step_x - into * nx, step_y - into * ny
    return jnp.where(possible, slide_x, np.float32(0)), jnp.where(possible, slide_y, np.float32(0))
