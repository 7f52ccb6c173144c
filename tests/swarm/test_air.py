"""Random, crowded steps of the air against a plain simulation, transmission by transmission."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

NOISE, P_RS, SINR = 10**-9.4, 10**-8.2, 10.0
HALF = 10**-0.301


def history(state, agent):
    """Agents that held the packet in an agent's buffer."""
    return [i for i in range(len(state.holding)) if state.history[0, agent] >> i & 1]


def plain_air(state, links, intent, chosen):
    """One step of the air, transmission by transmission; ``chosen`` says whom the source serves on each channel.

    Returns packets' moves [(sender, receiver)], NI [3, n], and how near the closest decision was to its edge.
    """
    n = len(state.holding)
    on_air = []  # sender, receiver, channel, level
    for i in range(n):
        if intent.sends[i] and state.holding[i] and intent.node[i] < n + 2:
            on_air.append((i, int(intent.node[i]), int(intent.channel[i]), float(intent.level[i])))
    on_air += [(n, i, channel, float(intent.level[i])) for channel, i in chosen.items()]
    power, jamming = links.power.astype(float), links.jamming.astype(float)
    decoded, edge = [], 1.0
    for m, (u, v, c, level) in enumerate(on_air):
        others = sum(power[a, v] * s for k, (a, _, b, s) in enumerate(on_air) if k != m and b == c)
        signal, ratio = power[u, v] * level, power[u, v] * level / (NOISE + jamming[c, v] + others)
        edge = min(edge, abs(signal / P_RS - 1), abs(ratio / SINR - 1))
        silent = not any(a == v and b == c for a, _, b, _ in on_air)
        free = v >= n or not state.holding[v]
        if signal >= P_RS and ratio >= SINR and silent and free:
            decoded.append((signal, u, v, c))
    boxes = {}
    for signal, u, v, c in decoded:
        box = v if v < n else (v, c)
        if box not in boxes or signal > boxes[box][0]:
            boxes[box] = (signal, u, v, c)
    moves = [(u, v, c) for _, u, v, c in boxes.values()]
    ni = np.full((len(jamming), n), NOISE) + jamming[:, :n]
    for u, _, c, level in on_air:
        for w in range(n):
            if w != u and (u, w, c) not in moves:
                ni[c, w] += power[u, w] * level
    return moves, ni, edge


def random_step(make, rng, n, channels):
    """A crowded, noisy step."""
    arena = make.arena(rng.uniform(0, 100, (n, 2)), channels=channels, width=3)
    holding = np.flatnonzero(rng.random(n) < 0.5).tolist()
    waiting = int(rng.integers(0, 4))
    history = rng.integers(0, 2**n, (1, n)) | (1 << np.arange(n))
    state = make.state(
        arena, t=int(rng.integers(0, 1000)), holding=holding, waiting=waiting, delivered=300 - waiting - len(holding),
        history=np.where(np.isin(np.arange(n), holding), history, 0),
    )  # fmt: skip
    power = 10 ** rng.uniform(-9.5, -5, (n + 2, n + 2)).astype(np.float32)
    power = np.triu(power, 1) + np.triu(power, 1).T
    jamming = np.zeros((3, n + 2), np.float32)
    jamming[channels[0]] = 10 ** rng.uniform(-11, -7, n + 2) * (rng.random() < 0.5)
    heard = [(i, j) for i in range(n) for j in range(n + 2) if i != j and rng.random() < 0.8]
    links = make.replace(make.links(n, heard=heard, jamming=jamming, channels=3), power=jnp.asarray(power))
    actions = {"sends": {}, "collects": {}, "moves": {}}
    for i in range(n):
        channel, level = int(rng.choice(channels)), float(rng.choice([1.0, np.float32(HALF)]))
        kind = rng.choice(["sends", "sends", "collects", "moves", "nothing"])
        if kind == "sends":
            node = int(rng.choice([j for j in range(n + 3) if j != i]))
            actions["sends"][i] = (node, channel, level)
        elif kind == "collects":
            actions["collects"][i] = (channel, level)
        elif kind == "moves":
            actions["moves"][i] = (0, 1.0, 1.0)
    return jax.device_get(state), jax.device_get(links), jax.device_get(make.intent(n, **actions))


@pytest.mark.parametrize("channels", [(0,), (0, 1, 2), (1, 2)])
def test_random_steps_against_a_plain_simulation(make, channels):
    rng = np.random.default_rng(channels[-1])
    n, outcomes = 6, {"relayed": 0, "delivered": 0, "returned": 0, "collected": 0, "lost": 0}
    for trial in range(80):
        state, links, intent = random_step(make, rng, n, channels)
        after, air = jax.device_get(make.transfer(state, links, intent, make.physics().radio))
        chosen, left = {}, int(state.waiting)
        for c in range(3):
            askers = {i for i in range(n) if intent.collects[i] and intent.channel[i] == c
                      and links.heard[n, i] and not state.holding[i]}  # fmt: skip
            served = np.flatnonzero(air.wanted[c, n]).tolist()
            assert len(served) == (1 if askers and left else 0)
            assert set(served) <= askers
            left -= len(served)
            chosen |= {c: served[0]} if served else {}
        moves, ni, edge = plain_air(state, links, intent, chosen)
        if edge < 1e-4:
            continue
        assert {(u, v, c) for c, u, v in np.argwhere(air.accepted)} == set(moves), trial
        np.testing.assert_allclose(after.interference, ni, rtol=1e-4)
        check_hand_over(state, after, [(u, v) for u, v, _ in moves], n)
        count(outcomes, moves, air, n)
    assert all(outcomes.values()), outcomes


def count(outcomes, moves, air, n):
    outcomes["lost"] += int(air.wanted.sum()) - len(moves)
    for u, v, _ in moves:
        outcomes["collected" if u == n else "delivered" if v == n + 1 else "returned" if v == n else "relayed"] += 1


def check_hand_over(before, after, moves, n):
    """Packets, histories and contributions after the moves (sender, receiver)."""
    holding, past = before.holding.copy(), {i: history(before, i) for i in range(n)}
    waiting, delivered, contribution = int(before.waiting), int(before.delivered), before.contribution.copy()
    for u, v in moves:
        carried = [] if u == n else history(before, u)
        waiting -= u == n
        if u < n:
            holding[u], past[u] = False, []
        waiting += v == n
        delivered += v == n + 1
        if v == n + 1:
            contribution[carried] += 1
        if v < n:
            holding[v], past[v] = True, sorted({*carried, v})
    np.testing.assert_array_equal(after.holding, holding)
    assert [history(after, i) for i in range(n)] == [past[i] for i in range(n)]
    assert (int(after.waiting), int(after.delivered)) == (waiting, delivered)
    np.testing.assert_array_equal(after.contribution, contribution)
    assert int(after.waiting) + int(after.holding.sum()) + int(after.delivered) == 300
