// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/base/base_facts.hpp"

namespace slam {

/// ros_arduino_bridge: `e` at 50 Hz, `m` in between.
std::unique_ptr<BaseProtocol> makeArduinoProtocol(const BaseProtocolConfig& config);

}  // namespace slam
