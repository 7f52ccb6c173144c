// Packets on the air: collecting, sending, interference, and who holds what afterwards. See swarm/packets.py.
#pragma once
#include "radio.h"
#include "randomness.h"
#include "state.h"

namespace slcs2 {

constexpr int NOBODY = -1;

// Who is on the air on a channel in any episode, in the order of the nodes; the source is the last.
struct Transmitters {
  int count;
  int node[MOST_AGENTS + 1];
  Mask on[MOST_AGENTS + 1];
  Ints target[MOST_AGENTS + 1];
  Floats level[MOST_AGENTS + 1];  // 0 where silent

  void add(int who, Mask on_air, Ints to, Floats power) {
    if (!any(on_air)) return;
    node[count] = who, on[count] = on_air, target[count] = to, level[count] = where(on_air, power);
    count++;
  }
};

// What a step's transmissions came to.
struct Traffic {
  Mask held[MOST_AGENTS], sent[MOST_AGENTS], received[MOST_AGENTS];
  Floats progress[MOST_AGENTS];                  // m, of the packets handed over, credited to sender and receiver
  Transmitters air[MOST_CHANNELS];
  Ints asker[MOST_CHANNELS];                     // whom the source serves on each channel, or NOBODY
  Ints taken_from[MOST_AGENTS], taken_on[MOST_AGENTS];  // whose packet an agent takes, or NOBODY, and on which channel
  Ints node_takes[MOST_CHANNELS][2];             // whose packet source and sink take on each channel, or NOBODY
};

// Whom the source serves on a channel: one of those that ask there, heard it and hold nothing; NOBODY if none does.
inline Ints choose_asker(const Group& g, int channel, Mask left, const Stream<Words>& lots) {
  Ints asker = all(NOBODY);
  Words best = all(0u);
  for (int i = 0; i < g.n; i++) {
    const Intent& intent = g.intent[i];
    const Mask asks = intent.collects & (intent.channel == channel) & g.heard[(size_t)i * g.nodes + g.n] &
                      ~g.holding[i] & left;
    if (!any(asks)) continue;
    const Words lot = lots.draw((uint32_t)i);
    const Mask better = asks & ((asker == NOBODY) | (Mask)(lot > best));
    asker = better ? all(i) : asker;
    best = (Words)(better ? (Ints)lot : (Ints)best);
  }
  return asker;
}

inline void put_on_the_air(const Group& g, int channel, Ints asker, Transmitters& air) {
  air.count = 0;
  Floats level = all(0.0f);
  for (int i = 0; i < g.n; i++) {
    const Intent& intent = g.intent[i];
    air.add(i, intent.sends & g.holding[i] & (intent.node < g.nodes) & (intent.channel == channel), intent.node,
            intent.level);
    level = asker == i ? intent.level : level;
  }
  air.add(g.n, asker != NOBODY, asker, level);
}

// The signals of a channel at one receiver. The disturbance of one is the sum of all others; the strongest is never
// subtracted from a sum that it dominates: for it the others are added up.
struct Signals {
  Floats of[MOST_AGENTS + 1], strongest = all(-1.0f), rest = all(0.0f);
  Ints first = all(0);  // the strongest's place among the transmitters

  Signals(const Group& g, const Transmitters& air, int receiver) {
    const Floats* power = g.power_of(receiver);
    for (int s = 0; s < air.count; s++) {
      of[s] = air.level[s] * power[air.node[s]];
      const Mask stronger = of[s] > strongest;
      strongest = stronger ? of[s] : strongest, first = stronger ? all(s) : first;
    }
    for (int s = 0; s < air.count; s++) rest += where(first != s, of[s]);
  }

  Floats others(int s) const { return first == s ? rest : rest + (strongest - of[s]); }
};

// One channel at one receiver: whose packet it can take, the strongest of those that it decodes.
inline void receive(const Group& g, const Transmitters& air, int channel, int receiver, Mask able, Floats& best,
                    Ints& from, Ints& on) {
  Mask wanted[MOST_AGENTS + 1], any_wanted = mask(false);
  for (int s = 0; s < air.count; s++) any_wanted |= wanted[s] = air.on[s] & able & (air.target[s] == receiver);
  if (!any(any_wanted)) return;
  const Signals signals(g, air, receiver);
  for (int s = 0; s < air.count; s++) {
    if (!any(wanted[s])) continue;
    const Floats signal = signals.of[s], jamming = g.jamming[(size_t)channel * g.nodes + receiver];
    const Mask decoded = wanted[s] & decodable(signal, jamming + signals.others(s), g.parameters);
    const Mask better = decoded & ((signal > best) | ((signal == best) & (air.node[s] < from)));
    best = better ? signal : best, from = better ? all(air.node[s]) : from, on = better ? all(channel) : on;
  }
}

// NI: noise, jammer and every data signal but the one that the agent took, per channel.
inline void measure_interference(Group& g, const Traffic& traffic) {
  const Transmitters* air = traffic.air;
  for (int i = 0; i < g.n; i++) {
    const Floats* power = g.power_of(i);
    for (int c = 0; c < g.channels; c++) {
      Floats unwanted = all(0.0f);
      for (int s = 0; s < air[c].count; s++) {
        const Mask taken = (traffic.taken_from[i] == air[c].node[s]) & (traffic.taken_on[i] == c);
        unwanted += where(~taken, air[c].level[s] * power[air[c].node[s]]);
      }
      g.interference[(size_t)i * g.channels + c] =
          g.parameters.noise + g.jamming[(size_t)c * g.nodes + i] + unwanted;
    }
  }
}

// Agent `receiver` takes its packet: the history moves along, and both are credited with the progress.
inline void take_packet(Group& g, Traffic& traffic, int receiver, Floats source_to_sink) {
  const Ints from = traffic.taken_from[receiver];
  const Mask received = from != NOBODY;
  if (!any(received)) return;
  const int words = g.sizes.history_words();
  Words* own = g.history + (size_t)receiver * words;
  for (int w = 0; w < words; w++) own[w] = (Words)(received ? Ints{} : (Ints)own[w]);
  for (int q = 0; q < g.n; q++) {
    const Mask m = from == q;
    if (!any(m)) continue;
    for (int w = 0; w < words; w++) own[w] |= (Words)m & g.history[(size_t)q * words + w];
    const Floats approach = where(m, g.to_sink[q] - g.to_sink[receiver]);
    traffic.sent[q] |= m;
    traffic.progress[q] += approach, traffic.progress[receiver] += approach;
  }
  own[receiver / WORD] |= (Words)received & (1u << (receiver % WORD));
  const Mask collected = from == g.n;
  traffic.progress[receiver] += where(collected, source_to_sink - g.to_sink[receiver]);
  traffic.received[receiver] = received;
  g.waiting += collected;
}

// Source (node 0) or sink (node 1) takes the packet of agent q where the mask says so.
inline void deliver(Group& g, Traffic& traffic, int node, int q, Mask m, Floats node_to_sink) {
  traffic.sent[q] |= m;
  traffic.progress[q] += where(m, g.to_sink[q] - node_to_sink);
  if (node == 0) {
    g.waiting -= m;
    return;
  }
  g.delivered -= m;
  const Words* history = g.history + (size_t)q * g.sizes.history_words();
  for (int h = 0; h < g.n; h++) g.contribution[h] += (Ints)(history[h / WORD] >> (h % WORD) & 1u) & m;
}

// Move the packets and their histories, and credit all who held a delivered one (paper, contribution).
inline void hand_over(Group& g, Traffic& traffic) {
  const Floats to_sink[2] = {root(squared(g.estimate_x) + squared(g.estimate_y)),
                             root(squared_distance(g.sink_x, g.sink_y, g.estimate_x, g.estimate_y))};
  for (int r = 0; r < g.n; r++) take_packet(g, traffic, r, to_sink[0]);
  for (int c = 0; c < g.channels; c++)
    for (int node = 0; node < 2; node++)
      for (int q = 0; any(traffic.node_takes[c][node] != NOBODY) && q < g.n; q++) {
        const Mask m = traffic.node_takes[c][node] == q;
        if (any(m)) deliver(g, traffic, node, q, m, to_sink[node]);
      }
  const int words = g.sizes.history_words();
  for (int i = 0; i < g.n; i++) {
    const Mask gone = traffic.sent[i] & ~traffic.received[i];
    for (int w = 0; w < words; w++) g.history[(size_t)i * words + w] &= ~(Words)gone;
    g.holding[i] = (g.holding[i] & ~traffic.sent[i]) | traffic.received[i];
  }
}

// Put every transmission of the step on the air and move the packets that get through.
inline void transfer(Group& g, Traffic& traffic) {
  const Stream<Words> lots = stream(g.key_low, g.key_high, g.t, COLLECT);
  Transmitters* air = traffic.air;
  Ints served = all(0);
  bool silent = true;
  for (int i = 0; i < g.n; i++) {
    traffic.held[i] = g.holding[i];
    traffic.sent[i] = traffic.received[i] = mask(false);
    traffic.progress[i] = all(0.0f), traffic.taken_from[i] = traffic.taken_on[i] = all(NOBODY);
  }
  for (int c = 0; c < g.channels; c++) {
    traffic.asker[c] = choose_asker(g, c, g.waiting > served, lots);
    traffic.node_takes[c][0] = traffic.node_takes[c][1] = all(NOBODY);
    put_on_the_air(g, c, traffic.asker[c], air[c]);
    served -= traffic.asker[c] != NOBODY;
    silent &= air[c].count == 0;
  }
  if (!silent) {
    Floats best[MOST_AGENTS];
    for (int i = 0; i < g.n; i++) best[i] = all(-1.0f);
    for (int c = 0; c < g.channels; c++) {
      if (air[c].count == 0) continue;
      for (int i = 0; i < g.n; i++)
        receive(g, air[c], c, i, ~g.holding[i], best[i], traffic.taken_from[i], traffic.taken_on[i]);
      for (int node = 0; node < 2; node++) {
        const Mask able = node == 0 ? traffic.asker[c] == NOBODY : mask(true);
        Floats strongest = all(-1.0f);
        Ints channel = all(NOBODY);
        receive(g, air[c], c, g.n + node, able, strongest, traffic.node_takes[c][node], channel);
      }
    }
  }
  measure_interference(g, traffic);
  if (!silent) hand_over(g, traffic);
}

}  // namespace slcs2
