// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/imu/imu_protocol.hpp"

namespace slam {

/// CEVA (Hillcrest, Bosch) BNO080, BNO085, BNO086 in UART-RVC mode: it only sends. It measures no turn rate; that comes
/// from the difference of its attitudes.
std::unique_ptr<ImuProtocol> makeBno08xProtocol();

}  // namespace slam
