// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/imu/imu_protocol.hpp"

namespace slam {

/// HandsFree A9, B6, B9, D6: which of the two framings it uses is found out from what comes.
std::unique_ptr<ImuProtocol> makeHfiProtocol();

}  // namespace slam
