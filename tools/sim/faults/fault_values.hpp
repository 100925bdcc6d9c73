// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

namespace slam::sim {

/// Values of faults that a script injects into an emulator. @return false: not a value of that kind, nothing is changed
inline bool setSwitch(bool& fault, double value) {
  if (value != 0.0 && value != 1.0) return false;
  fault = value == 1.0;
  return true;
}

inline bool setCount(int& fault, double value, double most) {
  if (!(value >= 0.0) || value > most || value != std::floor(value)) return false;
  fault = static_cast<int>(value);
  return true;
}

}  // namespace slam::sim
