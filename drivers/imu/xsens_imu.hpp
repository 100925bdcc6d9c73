// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/imu/imu_protocol.hpp"

namespace slam {

/// Xsens MTi: frames of MTData2. One that has been left in its configuration state is sent back to measure; nothing of
/// its settings is changed.
std::unique_ptr<ImuProtocol> makeXsensProtocol();

}  // namespace slam
