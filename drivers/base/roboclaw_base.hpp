// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/base/base_facts.hpp"

namespace slam {

/// RoboClaw, motor 1 left: both counters at 50 Hz, both speeds in between.
std::unique_ptr<BaseProtocol> makeRoboclawProtocol(const BaseProtocolConfig& config);

}  // namespace slam
