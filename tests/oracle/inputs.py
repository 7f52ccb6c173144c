"""From settings, scenarios and rule masks to the named tuples of the oracle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from slcs2_jax.config.errors import InputError
from tests.oracle.model import Params, Rules, Walls, World
from tests.oracle.randomness import normal
from tests.oracle.words import CLAUSES, SPLIT

LOG_PER_DECIBEL = math.log(10.0) / 10.0


def make_params(radio: Any, swarm: Any, learning: Any, wall_thickness: float = 1.0) -> Params:
    """Params from any objects with the attributes of the configuration's Radio, Swarm and Learning."""
    receive = radio.receive_threshold_dbm * LOG_PER_DECIBEL
    budget = radio.power_dbm - radio.reference_loss_db - radio.receive_threshold_dbm
    final = learning.alpha_q if learning.alpha_q_final is None else learning.alpha_q_final
    return Params(
        packets=int(swarm.packets),
        speed=float(swarm.speed),
        clearance=float(swarm.clearance),
        lidar_range=float(swarm.lidar_range),
        half_thickness=wall_thickness / 2.0,
        sharing_period=int(swarm.sharing_period),
        distance_threshold=float(swarm.distance_threshold),
        tolerance=float(swarm.tolerance),
        network_range=float(radio.reference_distance * 10.0 ** (budget / (10.0 * radio.path_loss_exponent))),
        log_reference=(radio.power_dbm - radio.reference_loss_db) * LOG_PER_DECIBEL,
        reference_distance=float(radio.reference_distance),
        half_exponent=radio.path_loss_exponent / 2.0,
        log_shadowing=radio.shadowing_db * LOG_PER_DECIBEL,
        log_wall=radio.wall_loss_db * LOG_PER_DECIBEL,
        log_receive=receive,
        log_sinr=radio.sinr_threshold_db * LOG_PER_DECIBEL,
        log_noise=radio.noise_dbm * LOG_PER_DECIBEL,
        log_nothing=receive - 1.0,
        square_range=_square_range(radio, budget),
        receive=10.0 ** (radio.receive_threshold_dbm / 10.0),
        sinr=10.0 ** (radio.sinr_threshold_db / 10.0),
        noise=10.0 ** (radio.noise_dbm / 10.0),
        half_power=10.0 ** (radio.half_power_db / 10.0),
        alpha_grasp=float(learning.alpha_grasp),
        alpha_q=float(learning.alpha_q),
        alpha_q_final=float(final),
        beta_q=float(learning.beta_q),
        trace_decay=float(learning.trace_decay),
        bp_max=int(learning.bp_max),
        cost_move=float(learning.cost_move),
        cost_communicate=float(learning.cost_communicate),
    )


def _square_range(radio: Any, budget: float) -> float:
    """Squared distance at which the luckiest draw just makes up for the path loss, a little enlarged for rounding."""
    luck = radio.shadowing_db * normal(0xFFFFFFFF)
    reach = radio.reference_distance * 10.0 ** ((budget + luck) / (10.0 * radio.path_loss_exponent))
    return 1.001 * max(reach, radio.reference_distance) ** 2


def make_walls(rows: Any) -> Walls:
    """Walls from rows (line, low, high): [V, 3]."""
    table = np.asarray(rows, np.float64).reshape(-1, 3)
    if not (np.isfinite(table).all() and (table[:, 1] <= table[:, 2]).all()):
        raise InputError(f"walls: {table.tolist()}; rows of finite (line, low, high) with low <= high are accepted")
    line, low, high = np.ascontiguousarray(table[np.argsort(table[:, 0], kind="stable")].T)
    return Walls(line, low, high)


def _points(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    points = np.array(value, np.float64)
    if points.ndim != len(shape) or any(k not in (-1, m) for k, m in zip(shape, points.shape, strict=True)):
        raise InputError(f"{name}: shape {points.shape}; metres of shape {shape} are accepted")
    if not np.isfinite(points).all():
        raise InputError(f"{name}: {points.tolist()}; finite metres are accepted")
    return points


def make_world(
    *, start: Any, sink: Any, time_limit: int, source: Any = (0.0, 0.0), sink_estimate: Any = None, jammer: Any = None,
    vertical: Any = (), horizontal: Any = (),
) -> World:  # fmt: skip
    """A World.

    start [n, 2]; source, sink, sink_estimate (default: the sink), jammer (None: none) [2]; vertical, horizontal
    [V, 3] rows (line, low, high) of centre lines; all in metres. time_limit in steps.
    """
    agents = _points("start", start, (-1, 2))
    if len(agents) < 2:
        raise InputError(f"start: {len(agents)} agents; at least 2 are accepted")
    if time_limit < 1:
        raise InputError(f"time_limit: {time_limit}; at least 1 step is accepted")
    goal = _points("sink", sink, (2,))
    somewhere = goal if jammer is None else _points("jammer", jammer, (2,))
    return World(
        start=agents,
        fixed=np.stack([_points("source", source, (2,)), goal, somewhere]),
        sink_estimate=goal.copy() if sink_estimate is None else _points("sink_estimate", sink_estimate, (2,)),
        has_jammer=jammer is not None,
        vertical=make_walls(vertical),
        horizontal=make_walls(horizontal),
        time_limit=int(time_limit),
    )


def make_rules(mask: Any, action: Any, channels_used: Any) -> Rules:
    """Rules from mask uint32[n, R, 4], bit k % 32 of word k // 32, action uint8[n, R], channels_used bool[3]."""
    words = np.asarray(mask, np.uint32)
    actions = np.array(action, np.uint8)
    channels = np.array(channels_used, np.bool_)
    if words.ndim != 3 or words.shape[2] != 4 or words.shape[:2] != actions.shape:
        raise InputError(f"mask: shape {words.shape} with action {actions.shape}; [n, R, 4] and [n, R] are accepted")
    if channels.shape != (3,) or not channels.any():
        raise InputError(f"channels_used: {channels.tolist()}; three truth values, not all false, are accepted")
    return Rules(pack_clauses(words), actions, channels)


def pack_clauses(words: Any) -> np.ndarray:
    """Sets of clauses as the oracle has them, int64[..., 2], from uint32[..., 4] words of 32 clauses."""
    words = np.asarray(words, np.uint32)
    mask = np.zeros((*words.shape[:-1], 2), np.int64)
    for k in range(CLAUSES):
        holds = (words[..., k // 32] >> np.uint32(k % 32) & np.uint32(1)).astype(np.int64)
        mask[..., k // SPLIT] |= holds << (k % SPLIT)
    return mask


def unpack_clauses(mask: np.ndarray) -> np.ndarray:
    """The inverse of pack_clauses: uint32[..., 4] words of 32 clauses, which is how the grammar has them."""
    words = np.zeros((*mask.shape[:-1], 4), np.uint32)
    for k in range(CLAUSES):
        holds = (mask[..., k // SPLIT] >> (k % SPLIT) & 1).astype(np.uint32)
        words[..., k // 32] |= holds << np.uint32(k % 32)
    return words
