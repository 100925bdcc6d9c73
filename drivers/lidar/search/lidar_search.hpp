// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/byte_stream.hpp"
#include "drivers/lidar/lidar_facts.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"
#include "drivers/line_device.hpp"

namespace slam {

/// What a LidarSearch has come to.
struct LidarFinding {
  enum Family : std::uint8_t { kNone, kPackets, kRplidar, kHokuyo, kSick } family = kNone;
  const LidarFacts* facts = nullptr;  ///< of kPackets
  int baud = 0;                       ///< [bit/s] at which it was understood
  Problem problem{};                  ///< of kNone: why
  bool is_open = true;                ///< the port could be opened
  RecognisedDevice other{};           ///< of kNone: who is there that is no lidar, if that is known
  bool has_bytes = false;             ///< of kNone: bytes came

  /// There is nothing more to be found out: a lidar or another device is known, or the port is gone.
  bool isDecided() const { return family != kNone || !is_open || isOtherDevice(other.line_device); }
};

/// Finds out which lidar is on a port. It listens first at the baud rates of those that send unasked: three good
/// packets in a row name the family, their rate the model. Then it asks what no device is harmed by: RPLidars and
/// YDLIDARs who they are, Hokuyos and SICKs the same. A lidar that must be started before it can be known (LDS-01,
/// COIN-D4) is not found, but by wake(). It may wait and allocate, some seconds in all; the port must be closed
/// meanwhile.
class LidarSearch {
 public:
  using Clock = rplidar::Dialogue::Clock;

  /// @param baud [bit/s] the only one to be tried; 0: all
  LidarSearch(std::string path, int baud, PortOpener open, Clock now)
      : path_(std::move(path)), baud_(baud), open_(std::move(open)), now_(now) {}

  LidarFinding find(const std::atomic<bool>& cancel);
  /// The first half of find(), which sends nothing to a silent port: at the baud rates of those that send unasked.
  LidarFinding listen(const std::atomic<bool>& cancel);
  /// The second half.
  LidarFinding ask(const std::atomic<bool>& cancel);
  /// Starts those that neither send nor answer before, and stops them: a motor turns meanwhile. For a port on which
  /// nobody else is known to be.
  LidarFinding wake(const std::atomic<bool>& cancel);

 private:
  template <typename Look>
  bool tryEach(std::span<const int> bauds, const std::atomic<bool>& cancel, const Look& look);
  LidarFinding receivePackets(rplidar::Dialogue& dialogue, int baud);
  LidarFinding listenTo(rplidar::Dialogue& dialogue, int baud, Duration limit);
  LidarFinding finish(const std::atomic<bool>& cancel);
  LidarFinding askRplidar(rplidar::Dialogue& dialogue, int baud) const;
  LidarFinding askYdlidar(rplidar::Dialogue& dialogue, int baud) const;
  LidarFinding askText(rplidar::Dialogue& dialogue, int baud) const;

  std::string path_;
  int baud_;  // [bit/s]
  PortOpener open_;
  Clock now_;
  LidarFinding found_;
  bool has_bytes_ = false;  // bytes that are no lidar's
};

/// The row for a YDLIDAR that answers with this model number; nullptr: none is known.
const LidarFacts* ydlidarOf(int model);

}  // namespace slam
