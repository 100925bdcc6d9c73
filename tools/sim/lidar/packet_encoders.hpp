// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// What a packet of samples is made of.
struct PacketContents {
  std::vector<double> angles{};  ///< [deg] of each sample as the unit reports it, 0..360
  std::vector<double> ranges{};  ///< [m]; 0: no echo
  double turn_rate = 10.0;       ///< [1/s]
  Duration uptime{0};            ///< of the unit
};

/// How a make packs its samples. A unit that is simulated is a row of packetFormats().
struct PacketFormat {
  const char* driver;  ///< word of lidar.driver
  std::vector<std::uint8_t> (*encode)(const PacketContents&);
  double (*shift)(double distance_mm) = nullptr;  ///< [deg] of a beam against the angle reported, in the angles' sense
  int samples = 12;                               ///< of a packet
  double turn_rate = 10.0;                        ///< [1/s] nominal
  bool fixed = false;                             ///< one sample a degree, whatever the turn rate
};

/// @return nullptr for a lidar that nobody simulates
const PacketFormat* findPacketFormat(std::string_view driver);

/// The model that is played for a word of lidar.driver: the word itself, but for a family.
std::string_view lidarModel(std::string_view word);

/// All that slam-sim plays: RPLidars, Hokuyos and SICKs by their models, and the drivers of all rows.
std::vector<std::string> lidarNames();

}  // namespace slam::sim
