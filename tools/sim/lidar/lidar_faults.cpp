// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_faults.hpp"

#include <algorithm>

namespace slam::sim {
namespace {

bool set(bool& flag, double value) {
  if (value != 0.0 && value != 1.0) return false;
  flag = value == 1.0;
  return true;
}
bool set(int& count, double value, double most) {
  if (value < 0.0 || value > most || value != std::floor(value)) return false;
  count = static_cast<int>(value);
  return true;
}
bool set(double& number, double value, double least, double most) {
  if (value < least || value > most) return false;
  number = value;
  return true;
}

}  // namespace

bool LidarFaults::inject(std::string_view kind, double value) {
  constexpr double kMany = 1e6, kMostStale = 4096.0, kLongestPause = 600e3;
  if (!std::isfinite(value)) return false;
  if (kind == "silent") return set(silent, value);
  if (kind == "health") return set(health, value, 2.0);
  if (kind == "stall") return set(stalled, value);
  if (kind == "lose") return set(lose, value, kMany);
  if (kind == "insert") return set(insert, value, kMany);
  if (kind == "flip") return set(flip, value, kMany);
  if (kind == "checksum") return set(checksum, value, kMany);
  if (kind == "stale") return set(stale, value, kMostStale);
  if (kind == "wrong") return set(range_factor, value, 0.1, 10.0);
  if (kind == "echoes") return set(echoes, value, 0.0, 1.0);
  if (kind == "dust") return set(dust, value, 0.0, 1.0);
  if (kind == "other") return set(other, value, 3.0);
  if (kind == "unit") {
    if (value != 0.0 && value != 1.0 && value != 3.0) return false;
    unit = value == 0.0 ? a1Firmware129() : value == 1.0 ? c1() : s3();
    return true;
  }
  if (kind == "encoder_reset") return encoder_reset = true;
  if (kind == "reboot") return reboot = true;
  if (kind == "pause") {
    double ms = 0.0;
    if (!set(ms, value, 0.0, kLongestPause)) return false;
    pause = fromSeconds(1e-3 * ms);
    return true;
  }
  if (kind == "turn") {
    double ms = 0.0;
    if (!set(ms, value, 50.0, 60000.0)) return false;
    turn = 1e-3 * ms;
    return true;
  }
  if (kind == "stuck") return set(stuck, value);
  return false;
}

LidarFaults::Fate LidarFaults::nextFate() {
  constexpr double kNearest = 0.16, kFurthest = 0.5;  // [m] of a mote
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Fate fate;
  if (dust > 0.0 && share(random_) < dust) fate.mote = kNearest + (kFurthest - kNearest) * share(random_);
  if (echoes < 1.0) fate.lost = share(random_) >= echoes;
  return fate;
}

void LidarFaults::damage(std::vector<std::uint8_t>& packet, bool capsule) {
  const auto place = [&] { return static_cast<std::ptrdiff_t>(random_() % packet.size()); };
  if (checksum > 0) {
    --checksum;
    packet[capsule ? packet.size() - 1 : 1] ^= 1;
  }
  for (; flip > 0; --flip) packet[static_cast<std::size_t>(place())] ^= static_cast<std::uint8_t>(1 + random_() % 255);
  if (insert > 0) {
    --insert;
    packet.insert(packet.begin() + place(), static_cast<std::uint8_t>(random_()));
  }
  if (lose > 0) {
    --lose;
    packet.erase(packet.begin() + place());
  }
}

}  // namespace slam::sim
