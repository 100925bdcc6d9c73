// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "drivers/lidar/codec/lidar_packets.hpp"

/// LDROBOT's packet of twelve samples, which Oradar's MS200 sends, too: `54 2C`, u16 speed [deg/s], u16 angle of the
/// first sample [0.01 deg], 12 x (u16 distance [mm], u8 intensity), u16 angle of the last one, u16 time [ms], CRC-8.
namespace slam::ldrobot {

inline constexpr std::size_t kSamples = 12, kSize = 47;  // of a packet; the latter in bytes

/// Polynomial 4D, from 0, not reflected.
std::uint8_t crc8(LidarPackets::Bytes bytes);

extern const LidarPackets kPackets;      ///< of the units that measure the time of flight
extern const LidarPackets kLd08Packets;  ///< of the LD08, which triangulates

/// Clockwise shift [deg] of an LD08's beam against its packet's angle, as its maker's driver has it.
double ld08Shift(double distance_mm);

}  // namespace slam::ldrobot
