// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lidar/lidar_unit.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"

namespace slam {

/// A TiM or LMS of SICK, by CoLa A over TCP. Its settings stay as they are; nobody logs in.
class ColaUnit : public LidarUnit {
 public:
  /// @param limits written into the scans
  ColaUnit(const RangeLimits& limits, Clock now) : limits_(limits), now_(now) {}

  Begun begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) override;
  Problem silence(const LidarReader& scan) override;
  void end() override;

 private:
  std::optional<std::string> ask(std::string_view request, std::string_view answer, Duration limit);
  Begun startScan(const std::string& telegram);

  RangeLimits limits_;
  Clock now_;
  ByteStream* port_ = nullptr;
  std::unique_ptr<rplidar::Dialogue> dialogue_;
  std::vector<std::uint8_t> read_ahead_;  // behind the last answer
};

}  // namespace slam
