// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <limits>
#include <vector>

namespace slam::test {

/// Numbers of both signs beyond a limit, from just beyond it to the largest there are, and what is no number.
inline std::vector<double> absurdNumbers(double limit) {
  std::vector<double> numbers = {std::numeric_limits<double>::quiet_NaN()};
  for (const double sign : {1.0, -1.0}) {
    for (const double value : {1.001 * limit, 2.0 * limit, std::numeric_limits<double>::max(), HUGE_VAL})
      numbers.push_back(sign * value);
    for (double value = 10.0 * limit; value < 1e308; value *= 1e5) numbers.push_back(sign * value);
  }
  return numbers;
}

/// Numbers up to a limit, and those next to zero.
inline std::vector<double> plausibleNumbers(double limit) {
  std::vector<double> numbers = {0.0, -0.0};
  for (const double sign : {1.0, -1.0}) {
    for (const double value : {std::numeric_limits<double>::denorm_min(), 1e-310, 1e-9, 0.5 * limit, limit})
      numbers.push_back(sign * value);
  }
  return numbers;
}

}  // namespace slam::test
