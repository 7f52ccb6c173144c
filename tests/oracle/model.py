"""What the oracle's episode is made of: plain arrays in named tuples, which both Python and Numba accept.

n agents, R rules each, M = n + 3 nodes (agents 0..n-1, source n, sink n+1, jammer n+2), V or H walls,
L = bp_max + 1 remembered action sets. Lengths in metres, powers in milliwatts, `log_*` their natural logarithms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Params(NamedTuple):
    """Everything that is set by the configuration, in the units the formulas use (see inputs.make_params)."""

    packets: int
    speed: float  # m per step
    clearance: float
    lidar_range: float
    half_thickness: float  # of a wall
    sharing_period: int  # steps
    distance_threshold: float
    tolerance: float  # relative, of `=`
    network_range: float
    log_reference: float  # full power received at the reference distance
    reference_distance: float
    half_exponent: float  # half the path-loss exponent: it multiplies the logarithm of a squared distance
    log_shadowing: float  # standard deviation
    log_wall: float  # loss per wall
    log_receive: float  # weakest power that is received at all
    log_sinr: float
    log_noise: float
    log_nothing: float  # below everything that is received
    square_range: float  # squared distance beyond which no draw makes a beacon heard
    receive: float
    sinr: float
    noise: float
    half_power: float  # as a fraction of full power
    alpha_grasp: float
    alpha_q: float
    alpha_q_final: float
    beta_q: float
    trace_decay: float
    bp_max: int
    cost_move: float
    cost_communicate: float


class Walls(NamedTuple):
    """Walls of one orientation, sorted by the coordinate of their centre line."""

    line: np.ndarray  # [V] x of a vertical wall, y of a horizontal one
    low: np.ndarray  # [V] where it begins along the other axis
    high: np.ndarray  # [V] where it ends


class World(NamedTuple):
    """One scenario."""

    start: np.ndarray  # [n, 2]
    fixed: np.ndarray  # [3, 2] source, sink, jammer (anywhere if there is none)
    sink_estimate: np.ndarray  # [2] where the agents believe the sink
    has_jammer: bool
    vertical: Walls
    horizontal: Walls
    time_limit: int


class Rules(NamedTuple):
    """One solution's rules."""

    mask: np.ndarray  # int64[n, R, 2] clause k is bit k of word 0, or bit k - SPLIT of word 1 (words.SPLIT)
    action: np.ndarray  # uint8[n, R]
    channels: np.ndarray  # bool[3] the channels that the grammar uses


class State(NamedTuple):
    """An episode between two steps; step t of the episode leaves its action sets in slot t % L."""

    place: np.ndarray  # [M, 2] only the agents' rows change
    holding: np.ndarray  # bool[n]
    history: np.ndarray  # bool[n, n] who has held the packet that the agent holds
    depot: np.ndarray  # int64[2] packets waiting at the source, packets delivered
    contribution: np.ndarray  # int64[n]
    known_time: np.ndarray  # int64[n, n] when the other was last heard of, -1 never
    known_place: np.ndarray  # [n, n, 2] where it was then
    jammer_range: np.ndarray  # [n] 0: jammer unknown
    interference: np.ndarray  # [n, 3] noise and interference of the last step per channel, mW (NI)
    quality: np.ndarray  # [n, R]
    error: np.ndarray  # [n, R]
    usage: np.ndarray  # int64[n, R]
    strength: np.ndarray  # [n, R] what the action sets that left the memory have earned
    reward: np.ndarray  # [n] of the last step
    past_set: np.ndarray  # uint16[n, L, R] the rules of the remembered action sets
    past_size: np.ndarray  # int64[n, L] and how many they are
    past_credit: np.ndarray  # [n, L] log10(|reward| + 1) with the reward's sign


class Work(NamedTuple):
    """Scratch space of a step, kept so that the step loop allocates nothing; what a step derives stands here."""

    jam: np.ndarray  # [n + 2] power of the jammer at the nodes, mW, 0 while it is silent
    floor: np.ndarray  # [n] weakest log power at which the agent decodes a beacon
    heard: np.ndarray  # bool[n, n + 2] agent hears the beacon of node
    role: np.ndarray  # int64[n, 3] so, si, c among the known nodes, -1 none
    distance: np.ndarray  # [n, 8] so, si, c, sink, source, threshold, network range, jammer range; -1 undefined
    reachable: np.ndarray  # int64[3] one agent's so, si, c among the heard nodes
    reach_distance: np.ndarray  # [3]
    truth: np.ndarray  # int64[n, 2] which clauses hold
    matched_truth: np.ndarray  # int64[n, 2] the truth that the match set belongs to
    match: np.ndarray  # uint16[n, R] the rules of the match set
    match_size: np.ndarray  # int64[n] and how many they are, -1 before the first
    action: np.ndarray  # int64[n] NO_ACTION if nothing matched
    sender: np.ndarray  # int64[n + 3] transmitting node
    receiver: np.ndarray  # int64[n + 3] node the packet is for
    channel: np.ndarray  # int64[n + 3]
    power: np.ndarray  # [n + 3] fraction of full power
    signal: np.ndarray  # [n + 3, n + 2] power of the transmission at the node
    transmits: np.ndarray  # bool[n + 1, 3] agent or source transmits on channel
    accepted: np.ndarray  # int64[n + 6] transmission accepted by agent, source and sink per channel; -1 none
    held: np.ndarray  # bool[n] held a packet when the step began
    step: np.ndarray  # [n, 2] wanted displacement
    proposal: np.ndarray  # [n, 2]
    tangent: np.ndarray  # [n, 2] second choice of an agent whose proposal was refused
    slides: np.ndarray  # bool[n] it has one
    moved: np.ndarray  # [n, 2] where the agents end
    progress: np.ndarray  # [n] of the agent's packet
    shared_time: np.ndarray  # int64[n, n] copies, for sharing that is simultaneous
    shared_place: np.ndarray  # [n, n, 2]
    shared_range: np.ndarray  # [n]


def new_state(world: World, rules: Rules, params: Params) -> State:
    """The state before the first step."""
    n, count = rules.action.shape
    memory = params.bp_max + 1
    place = np.zeros((n + 3, 2))
    place[:n] = world.start
    place[n:] = world.fixed
    depot = np.zeros(2, np.int64)
    depot[0] = params.packets
    return State(
        place=place,
        holding=np.zeros(n, np.bool_),
        history=np.zeros((n, n), np.bool_),
        depot=depot,
        contribution=np.zeros(n, np.int64),
        known_time=np.full((n, n), -1, np.int64),
        known_place=np.zeros((n, n, 2)),
        jammer_range=np.zeros(n),
        interference=np.full((n, 3), params.noise),
        quality=np.zeros((n, count)),
        error=np.zeros((n, count)),
        usage=np.zeros((n, count), np.int64),
        strength=np.zeros((n, count)),
        reward=np.zeros(n),
        past_set=np.zeros((n, memory, count), np.uint16),
        past_size=np.zeros((n, memory), np.int64),
        past_credit=np.zeros((n, memory)),
    )


def new_work(world: World, rules: Rules) -> Work:
    """Scratch space for episodes with these rules (the remembered match sets are theirs)."""
    n, count = rules.action.shape
    return Work(
        jam=np.zeros(n + 2),
        floor=np.zeros(n),
        heard=np.zeros((n, n + 2), np.bool_),
        role=np.zeros((n, 3), np.int64),
        distance=np.zeros((n, 8)),
        reachable=np.zeros(3, np.int64),
        reach_distance=np.zeros(3),
        truth=np.zeros((n, 2), np.int64),
        matched_truth=np.zeros((n, 2), np.int64),
        match=np.zeros((n, count), np.uint16),
        match_size=np.full(n, -1, np.int64),
        action=np.zeros(n, np.int64),
        sender=np.zeros(n + 3, np.int64),
        receiver=np.zeros(n + 3, np.int64),
        channel=np.zeros(n + 3, np.int64),
        power=np.zeros(n + 3),
        signal=np.zeros((n + 3, n + 2)),
        transmits=np.zeros((n + 1, 3), np.bool_),
        accepted=np.zeros(n + 6, np.int64),
        held=np.zeros(n, np.bool_),
        step=np.zeros((n, 2)),
        proposal=np.zeros((n, 2)),
        tangent=np.zeros((n, 2)),
        slides=np.zeros(n, np.bool_),
        moved=np.zeros((n, 2)),
        progress=np.zeros(n),
        shared_time=np.zeros((n, n), np.int64),
        shared_place=np.zeros((n, n, 2)),
        shared_range=np.zeros(n),
    )
