// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "bus/udpm/lcm_link.hpp"
#include "core/estimates.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// Sends SLAM_DRIVE, once. @param twist in base @return false: it could not be sent
bool publishDrive(LcmLink& link, const Twist2& twist, Timestamp now);

}  // namespace slam
