// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "drivers/lidar/lidar_facts.hpp"
#include "drivers/lidar/lidar_unit.hpp"

namespace slam {

struct PacketLidarConfig {
  int baud = 0;          ///< [bit/s]
  RangeLimits limits{};  ///< written into the scans, where the unit does not reach less far
};

/// A lidar of the table: it sends packets, most often unasked.
class PacketLidar : public LidarUnit {
 public:
  static constexpr int kEnough = 3;  ///< good packets one behind the other: it is this lidar

  PacketLidar(const LidarFacts& facts, const PacketLidarConfig& config, Clock now)
      : facts_(facts), config_(config), now_(now) {}

  Begun begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) override;
  Problem silence(const LidarReader& scan) override;
  void end() override;

 private:
  Begun listen(rplidar::Dialogue& dialogue, WrongDevice& others) const;

  const LidarFacts& facts_;
  PacketLidarConfig config_;
  Clock now_;
  ByteStream* port_ = nullptr;
};

}  // namespace slam
