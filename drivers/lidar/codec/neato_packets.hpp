// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "drivers/lidar/codec/lidar_packets.hpp"

/// Small packets whose check sum is Neato's, or whose head is like Neato's.
namespace slam::neato {

/// XV-11, 22 bytes: `FA`, index A0 + i of the degrees 4i to 4i + 3, u16 speed, 4 x (u16 distance [mm] with flags, u16
/// strength), u16 check. Angles rise counter-clockwise.
extern const LidarPackets kXv11Packets;
/// TurtleBot3's LDS-01, 42 bytes: `FA`, index A0 + i of the degrees 6i to 6i + 5, u16 rpm * 10, 6 x (u16 intensity, u16
/// distance [mm], u16), two bytes that are both the complement of the bytes' sum, or something that is not known.
extern const LidarPackets kLds01Packets;
/// Camsense X1, 36 bytes: `55 AA 03 08`, u16 speed, u16 angle of the first sample [deg * 64 + A000], 8 x (u16 distance
/// [mm], u8 quality), u16 angle of the last one, u16 check.
extern const LidarPackets kCamsensePackets;

/// @param bytes an even number
unsigned checkOf(LidarPackets::Bytes bytes);

}  // namespace slam::neato
