// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "drivers/lidar/codec/lidar_packets.hpp"

/// YDLIDAR's packet, which the COIN-D4 sends, too: `AA 55`, u8 turn rate and start bit, u8 number of samples, u16 angle
/// of the first sample [deg * 128, bit 0 set], u16 of the last one, u16 check, samples.
namespace slam::ydlidar {

inline constexpr std::size_t kHead = 10, kMostSamples = 80;  // [bytes]; of a packet

extern const LidarPackets kPlainPackets;         ///< X2, X4, G4: u16 distance; the unit triangulates
extern const LidarPackets kBrightPackets;        ///< G2: u8 intensity before it
extern const LidarPackets kTimeOfFlightPackets;  ///< T-mini: the same, angles as they are
extern const LidarPackets kCoinPackets;          ///< COIN-D4: six bits of the quality before it

/// XOR of all 16-bit words but the check's own; an intensity is a word of its own.
/// @param width [bytes] of a sample: 2 or 3
unsigned checkOf(LidarPackets::Bytes packet, std::size_t width);
/// Clockwise shift [deg] of a triangulating unit's beam against its packet's angle.
double shiftOf(double distance_mm);

}  // namespace slam::ydlidar
