// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <string>

namespace slam {

/// What a counter is called and what it counts. Each struct of counters declares its own in its visitCounters(counters,
/// visit), which calls visit(CounterInfo, value) for one after the other. SLAM_HEALTH, the statistics of slam-replay
/// and docs/counters.md show whatever is visited. A value is a whole number, or a double: a share [1].
struct CounterInfo {
  std::string name;     ///< in SLAM_HEALTH
  std::string unit;     ///< what one is
  std::string meaning;  ///< one sentence
  std::string key{};    ///< in statistics; empty: the name, _ for each dot

  std::string statistic() const {
    std::string text = key.empty() ? name : key;
    std::replace(text.begin(), text.end(), '.', '_');
    return text;
  }
};

}  // namespace slam
