"""Packets on the air: collecting, sending, interference, and who holds what afterwards (model sections 3 and 4).

Senders are the agents and, last, the source (row n); receivers the agents, the source (n) and the sink (n + 1).
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from slcs2_jax.swarm.intent import Intent
from slcs2_jax.swarm.links import Links
from slcs2_jax.swarm.selection import first_of_least, least, rows
from slcs2_jax.swarm.state import WORD, State, lift
from slcs2_jax.world import randomness
from slcs2_jax.world.radio import RadioParameters, decodable


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Air:
    """Transmissions of a step, all [C, n + 1, n + 2, ...].

    Attributes:
        signal: float32, mW received from each sender that is on the air on the channel.
        wanted: bool, the sender is on the air there and addresses the receiver.
        decoded: bool, wanted and received well enough by a receiver that can take it.
        accepted: bool, the packet changes hands.
    """

    signal: jax.Array
    wanted: jax.Array
    decoded: jax.Array
    accepted: jax.Array


def transfer(state: State, links: Links, intent: Intent, radio: RadioParameters) -> tuple[State, Air]:
    """Put every transmission of the step on the air and move the packets that get through."""
    served = jnp.zeros_like(state.waiting)
    channels = []
    for channel in range(links.jamming.shape[0]):
        asker = _chosen_asker(channel, state.waiting > served, state, links, intent)
        served = served + jnp.any(asker, axis=0).astype(jnp.int32)
        channels.append(_transmit(channel, asker, state, links, intent, radio))
    signal, wanted, decoded = (jnp.stack(parts) for parts in zip(*channels, strict=True))
    air = Air(signal, wanted, decoded, _accept(signal, decoded, state.x.shape[0], radio.noise))
    return _hand_over(_measure(state, air, links, radio), air.accepted), air


def _chosen_asker(channel: int, left: jax.Array, state: State, links: Links, intent: Intent) -> jax.Array:
    """Whom the source serves on a channel: one of those that ask there, heard it and hold nothing: bool [n, ...]."""
    n = state.x.shape[0]
    asks = intent.collects & (intent.channel == channel) & links.heard[n] & ~state.holding & left
    number = rows(n, state.t)
    stream = randomness.stream(state.key, state.t, randomness.Purpose.COLLECT)
    lot = randomness.bits(stream, number.astype(np.uint32))
    lot = jnp.where(asks, lot, np.uint32(0))
    drawn = asks & (lot == jnp.max(lot, axis=0))
    return number == jnp.min(jnp.where(drawn, number, np.int32(n)), axis=0)


def _transmit(
    channel: int, asker: jax.Array, state: State, links: Links, intent: Intent, radio: RadioParameters
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """One channel: ``signal``, ``wanted`` and ``decoded`` of ``Air``, [n + 1, n + 2, ...] each."""
    n = state.x.shape[0]
    on_air = intent.sends & state.holding & (intent.node < n + 2) & (intent.channel == channel)
    serves = jnp.any(asker, axis=0)
    level = jnp.where(on_air, intent.level, np.float32(0))
    source_level = jnp.sum(jnp.where(asker, intent.level, np.float32(0)), axis=0)
    levels = jnp.concatenate([level, source_level[None]])
    signal = levels[:, None] * links.power[: n + 1]

    receiver = rows(n + 2, state.t)
    to_nodes = jnp.zeros((2, *asker.shape[1:]), bool)
    from_agents = (intent.node[:, None] == receiver) & on_air[:, None]
    wanted = jnp.concatenate([from_agents, jnp.concatenate([asker, to_nodes])[None]])

    disturbance = links.jamming[channel] + others(signal)
    nothing = jnp.zeros_like(serves)
    able = ~jnp.concatenate([on_air | state.holding, serves[None], nothing[None]])
    return signal, wanted, wanted & able & decodable(signal, disturbance, radio)


def others(signal: jax.Array) -> jax.Array:
    """At each receiver, the sum of all signals but the sender's own: float32 [senders, receivers, ...], mW.

    The strongest is never subtracted from a sum that it dominates: for it the others are added up.
    """
    sender = rows(signal.shape[0], signal[0])

    def in_two_passes(signal: jax.Array) -> tuple[jax.Array, jax.Array]:
        strongest = jnp.max(signal, axis=0)
        return jnp.min(jnp.where(signal == strongest, sender, np.int32(signal.shape[0])), axis=0), strongest

    def in_one_pass(signal: jax.Array) -> tuple[jax.Array, jax.Array]:
        first, least = first_of_least(-signal)
        return first, -least

    first, strongest = jax.lax.platform_dependent(signal, cpu=in_two_passes, default=in_one_pass)
    rest = jnp.sum(jnp.where(sender == first, np.float32(0), signal), axis=0)
    return jnp.where(sender == first, rest, rest + (strongest - signal))


def _accept(signal: jax.Array, decoded: jax.Array, n: int, witness: jax.Array) -> jax.Array:
    """An agent takes the strongest packet over all channels; source and sink take one per channel."""
    channels, senders, _, *batch = signal.shape

    def by_sender(table: jax.Array) -> jax.Array:
        """Agents' share of a table with senders and their channels on one axis: [(n + 1) * C, n, ...]."""
        return jnp.moveaxis(table[:, :, :n], 0, 1).reshape(senders * channels, n, *batch)

    taken = _strongest(by_sender(signal), by_sender(decoded), witness).reshape(senders, channels, n, *batch)
    to_nodes = [_strongest(signal[c, :, n:], decoded[c, :, n:], witness) for c in range(channels)]
    return jnp.concatenate([jnp.moveaxis(taken, 1, 0), jnp.stack(to_nodes)], axis=2)


def _strongest(signal: jax.Array, decoded: jax.Array, witness: jax.Array) -> jax.Array:
    """Mark the strongest decoded signal at each receiver, the first of equals: bool [senders, receivers, ...]."""
    first, _ = least(decoded, -signal, witness)
    return rows(signal.shape[0], signal[0]) == first


def _measure(state: State, air: Air, links: Links, radio: RadioParameters) -> State:
    """NI: noise, jammer and every data signal but the one accepted, per channel."""
    n = state.x.shape[0]
    unwanted = jnp.where(air.accepted[:, :, :n], np.float32(0), air.signal[:, :, :n])
    interference = radio.noise + links.jamming[:, :n] + jnp.sum(unwanted, axis=1)
    return dataclasses.replace(state, interference=interference)


def _hand_over(state: State, accepted: jax.Array) -> State:
    """Move the packets and their histories, and credit all who held a delivered one (model 7, contribution)."""
    n = state.x.shape[0]
    passed = jnp.any(accepted, axis=0)
    sent = jnp.any(passed[:n], axis=1)
    received = jnp.any(passed[:, :n], axis=0)
    collected = jnp.sum(passed[n, :n].astype(jnp.int32), axis=0)
    returned, delivered = (jnp.sum(passed[:n, node].astype(jnp.int32), axis=0) for node in (n, n + 1))

    agent = np.arange(n)
    word = lift(agent[None, :] // WORD == np.arange(state.history.shape[0])[:, None], state.t)
    place = lift((agent % WORD).astype(np.uint32), state.t)
    own = jnp.where(word, np.uint32(1) << place, np.uint32(0))
    moved = jnp.sum(jnp.where(passed[:n, :n], state.history[:, :, None], np.uint32(0)), axis=1, dtype=jnp.uint32)
    history = jnp.where(received, moved | own, jnp.where(sent, np.uint32(0), state.history))

    held = (state.history[agent // WORD] >> place[:, None]) & np.uint32(1)  # [holder, sender, ...]
    credit = jnp.sum(jnp.where(passed[:n, n + 1], held, np.uint32(0)).astype(jnp.int32), axis=1)
    return dataclasses.replace(
        state,
        holding=(state.holding & ~sent) | received,
        history=history,
        waiting=state.waiting - collected + returned,
        delivered=state.delivered + delivered,
        contribution=state.contribution + credit,
    )
