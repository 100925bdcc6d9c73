// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/base/base_facts.hpp"

namespace slam {

/// iRobot Create 2, Roomba: asked once for a stream of sensor packets; driven in safe mode.
std::unique_ptr<BaseProtocol> makeCreateProtocol(const BaseProtocolConfig& config);

}  // namespace slam
