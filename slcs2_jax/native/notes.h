// What is kept of every step of the first episode, for recordings: names and meaning as in looking/recording.py.
#pragma once
#include "buffers.h"
#include "classifier.h"
#include "packets.h"

namespace slcs2 {

// What became of a transmission (swarm/fate.py): the first thing in this order that alone would have lost it counts.
enum Fate : uint8_t { NONE, HANDED_OVER, WEAK, JAMMED, INTERFERED, REFUSED };

class Notes {
 public:
  Notes(const Sizes& s, const Buffers& buffers) : s_(s), to_(buffers.noted) {
    for (int k = 0; k < NOTED; k++) memset(to_[k], 0, noted_bytes(s, k));
  }

  // The state that a step starts from, once it is known who hears whom.
  void before(const Group& g, int step) {
    const size_t n = s_.agents, words = (s_.nodes() + WORD - 1) / WORD;
    at<uint8_t>(N_RUNNING, step) = g.running[0] != 0;
    at<int32_t>(N_WAITING, step) = g.waiting[0], at<int32_t>(N_DELIVERED, step) = g.delivered[0];
    jammers(g, step);
    for (size_t i = 0; i < n; i++) {
      at<float>(N_X, step * n + i) = g.x[i][0], at<float>(N_Y, step * n + i) = g.y[i][0];
      at<uint8_t>(N_HOLDING, step * n + i) = g.holding[i][0] != 0;
      at<uint8_t>(N_DOWN, step * n + i) = g.sizes.failing && g.down[i][0] != 0;
      for (size_t w = 0; w < words; w++) at<uint32_t>(N_HEARD, (step * words + w) * n + i) = 0;
      for (int j = 0; j < g.nodes; j++)
        if (g.heard[i * g.nodes + j][0]) at<uint32_t>(N_HEARD, (step * words + j / WORD) * n + i) |= 1u << (j % WORD);
    }
  }

  // What agent i decided.
  void decision(int step, int i, const Mind& mind, int action, int rule) {
    const size_t n = s_.agents;
    at<uint8_t>(N_ACTION, step * n + i) = (uint8_t)action;
    at<int16_t>(N_RULE, step * n + i) = (int16_t)rule;
    for_each(mind.match, mind.words, [&](int r) { at<int32_t>(N_MATCHED, r * n + i)++; });
  }

  // What became of the transmissions; before anybody moves.
  void traffic(const Group& g, int step, const Traffic& traffic) {
    const Transmitters* air = traffic.air;
    const size_t n = s_.agents;
    for (size_t i = 0; i < n; i++) {
      at<int8_t>(N_SENT_TO, step * n + i) = NOBODY, at<uint8_t>(N_SENT_FATE, step * n + i) = NONE;
    }
    for (int c = 0; c < g.channels; c++) {
      const size_t place = (size_t)step * g.channels + c;
      at<int8_t>(N_SERVED, place) = NOBODY, at<uint8_t>(N_SERVED_FATE, place) = NONE;
      for (int k = 0; k < air[c].count; k++) {
        if (!air[c].on[k][0]) continue;
        const int receiver = air[c].target[k][0], sender = air[c].node[k];
        const Fate became = fate(g, air[c], traffic, c, k, receiver);
        const bool serves = sender == g.n;
        at<int8_t>(serves ? N_SERVED : N_SENT_TO, serves ? place : step * n + sender) = (int8_t)receiver;
        at<uint8_t>(serves ? N_SERVED_FATE : N_SENT_FATE, serves ? place : step * n + sender) = became;
      }
    }
  }

 private:
  // Where the jammers are, and on which channel each emits.
  void jammers(const Group& g, int step) {
    const int count = s_.shown_jammers();
    for (int jammer = 0; jammer < count; jammer++) {
      const size_t place = (size_t)step * count + jammer;
      at<float>(N_JAMMER_X, place) = g.x[g.nodes + jammer][0], at<float>(N_JAMMER_Y, place) = g.y[g.nodes + jammer][0];
      at<int8_t>(N_JAMMED, place) = jammer < g.jammers_present ? (int8_t)g.emits[jammer][0] : NOBODY;
    }
    for (int c = g.channels - 1; s_.jammers == 0 && c >= 0; c--)
      for (int j = 0; j < g.nodes; j++)
        if (g.jamming[(size_t)c * g.nodes + j][0] > 0) at<int8_t>(N_JAMMED, step) = (int8_t)c;
  }

  template <class E>
  E& at(int which, size_t place) {
    return ((E*)to_[which])[place];
  }

  static Fate fate(const Group& g, const Transmitters& air, const Traffic& traffic, int c, int k, int receiver) {
    const int sender = air.node[k];
    const bool taken = receiver < g.n ? traffic.taken_from[receiver][0] == sender && traffic.taken_on[receiver][0] == c
                                      : traffic.node_takes[c][receiver - g.n][0] == sender;
    if (taken) return HANDED_OVER;
    const Floats signal = air.level[k] * g.power_of(receiver)[sender];
    const Floats jamming = g.jamming[(size_t)c * g.nodes + receiver];
    const Floats disturbance = jamming + Signals(g, air, receiver).others(k);
    if (!decodable(signal, all(0.0f), g.parameters)[0]) return WEAK;
    if (!decodable(signal, jamming, g.parameters)[0]) return JAMMED;
    return decodable(signal, disturbance, g.parameters)[0] ? REFUSED : INTERFERED;
  }

  const Sizes& s_;
  void* const* to_;
};

}  // namespace slcs2
