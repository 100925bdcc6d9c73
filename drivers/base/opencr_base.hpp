// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/base/base_facts.hpp"

namespace slam {

/// TurtleBot3's OpenCR: its control table at 50 Hz, heartbeats and speeds in between.
std::unique_ptr<BaseProtocol> makeOpencrProtocol(const BaseProtocolConfig& config);

}  // namespace slam
