// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "drivers/lidar/rplidar_unit.hpp"
#include "drivers/lidar/serial_lidar.hpp"

namespace slam::test {

/// A SerialLidar with an RplidarUnit, into which a test can look.
class Rplidar : public SerialLidar {
 public:
  Rplidar(const std::string& port, const RplidarConfig& config, Clock now, Sink sink, PortOpener open = openPort)
      : Rplidar(port, config, now, std::make_unique<RplidarUnit>(config, now), std::move(sink), std::move(open)) {}

  const rplidar::ScanMode& mode() const { return unit_.mode(); }

 private:
  Rplidar(const std::string& port, const RplidarConfig& config, Clock now, std::unique_ptr<RplidarUnit> unit, Sink sink,
          PortOpener open)
      : Rplidar{{.port = port, .baud = config.baud}, *unit, std::move(unit), now, std::move(sink), std::move(open)} {}
  Rplidar(const SerialLidarConfig& config, const RplidarUnit& seen, std::unique_ptr<RplidarUnit> unit, Clock now,
          Sink sink, PortOpener open)
      : SerialLidar(config, std::move(unit), now, std::move(sink), std::move(open)), unit_(seen) {}

  const RplidarUnit& unit_;
};

}  // namespace slam::test
