// The radio: received power, and what of it can be decoded. See world/radio.py and world/propagation.py.
#pragma once
#include "elementary.h"
#include "state.h"

namespace slcs2 {

// log2 of the mean power received over each link, mW: P_t - PL(d) - walls * L_w (world/propagation.py, LogDistance).
inline Floats level(Floats square, Floats walls, const Parameters& p) {
  return p.gain - p.slope * logarithm2(maximum(square, p.floor)) - p.wall * walls;
}

// Received: power >= P_rs and signal to interference and noise >= threshold.
inline Mask decodable(Floats signal, Floats disturbance, const Parameters& p) {
  return (signal >= p.sensitivity) & (signal >= p.threshold * (p.noise + disturbance));
}

}  // namespace slcs2
