// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "core/samples.hpp"
#include "core/scan.hpp"

namespace slam {

using LogSample = std::variant<std::unique_ptr<LaserScan>, WheelSample, ImuSample>;

inline bool isScan(const LogSample& sample) { return std::holds_alternative<std::unique_ptr<LaserScan>>(sample); }
Timestamp& stampIn(LogSample& sample);
Timestamp stampOf(const LogSample& sample);

/// What samples and stamps of a drive can suffer on their way.
struct StreamFault {
  std::string_view name;
  void (*add)(std::vector<LogSample>& samples);
};

/// @param name "-" for none
/// @throws std::invalid_argument with the known names
const StreamFault& streamFault(std::string_view name);

}  // namespace slam
