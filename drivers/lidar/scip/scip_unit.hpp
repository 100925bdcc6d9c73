// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/lidar/codec/scip_codec.hpp"
#include "drivers/lidar/lidar_unit.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"

namespace slam {

struct ScipConfig {
  int baud = 0;          ///< [bit/s] of a line of RS-232; 0: USB or Ethernet, where bytes take no time
  RangeLimits limits{};  ///< written into the scans, where the unit does not reach less far
};

/// A lidar of Hokuyo, by SCIP 2.0: what it measures is asked of it.
class ScipUnit : public LidarUnit {
 public:
  ScipUnit(const ScipConfig& config, Clock now) : config_(config), now_(now) {}

  Begun begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) override;
  Problem silence(const LidarReader& scan) override;
  void end() override;

 private:
  void send(const std::string& command);
  std::optional<scip::Answer> ask(const std::string& command, Duration limit);
  std::optional<scip::Answer> identify();
  Begun startScan(const scip::Parameters& unit);

  ScipConfig config_;
  Clock now_;
  ByteStream* port_ = nullptr;
  std::unique_ptr<rplidar::Dialogue> dialogue_;
  std::vector<std::uint8_t> read_ahead_;  // behind the last answer
};

}  // namespace slam
