// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/imu/imu_protocol.hpp"

namespace slam {

/// WitMotion WT901, HWT905, JY901 and their kin: it only sends.
std::unique_ptr<ImuProtocol> makeWitmotionProtocol();

}  // namespace slam
