// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "tools/sim/imu/emulated_imu.hpp"

namespace slam::sim {

/// A BNO08x in UART-RVC mode, level: its heading is the sum of its gyro, rounded.
std::unique_ptr<EmulatedImu> makeBno08x();
/// A WitMotion as delivered: acceleration, turn rate, angle and magnetic field.
std::unique_ptr<EmulatedImu> makeWitmotion();
/// An Xsens MTi with counter, sample time, acceleration and rate of turn. It measures, unless it is put into its
/// configuration state (fault "config") until it is sent back.
std::unique_ptr<EmulatedImu> makeXsens();

}  // namespace slam::sim
