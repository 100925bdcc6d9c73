// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/other_lidar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/lidar/packet_encoders.hpp"

namespace slam::sim {
namespace {

constexpr Duration kPacket = std::chrono::milliseconds(8);

const PacketFormat& formatOf(OtherLidar::Make make) {
  return *findPacketFormat(make == OtherLidar::kLdrobot   ? "ld06"
                           : make == OtherLidar::kYdlidar ? "ydlidar-x4"
                                                          : "xv11");
}

}  // namespace

void OtherLidar::stream(Make make, Timestamp now, const Look& look, std::vector<std::uint8_t>& out) {
  if (make == kNone) return;
  for (next_ = std::max(next_, now - 4 * kPacket); next_ <= now; next_ += kPacket) {
    const PacketFormat& format = formatOf(make);
    const double step = format.fixed ? 1.0 : 0.6;  // [deg]
    PacketContents contents;
    for (int i = 0; i < format.samples; ++i, angle_ = std::fmod(angle_ + step, 360.0)) {
      contents.angles.push_back(angle_);
      contents.ranges.push_back(look(-angle_ * std::numbers::pi / 180.0));
    }
    const std::vector<std::uint8_t> packet = format.encode(contents);
    out.insert(out.end(), packet.begin(), packet.end());
  }
}

}  // namespace slam::sim
