// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/samples.hpp"
#include "drivers/device_status.hpp"
#include "drivers/imu/imu_facts.hpp"
#include "drivers/polled_port.hpp"

namespace slam {

struct SerialImuConfig {
  const ImuFacts* facts = nullptr;  ///< row of the table
  std::string port = {};
  int baud = 0;                ///< [bit/s]; 0: whichever of the row's it is found at
  bool in_background = false;  ///< the port is opened by a thread of its own
};

/// Owns a stand-alone IMU on a serial port, of any make of the table.
///
/// Axes: the unit's x, y, z are taken to be forward, left, up of its mount, and its gyro counter-clockwise about them.
///
/// To be ticked at a fixed rate by one thread; a tick never waits, but for opening the port when there is none.
class SerialImu {
 public:
  using Sink = std::function<void(const ImuSample&)>;
  using Clock = Timestamp (*)();

  SerialImu(const SerialImuConfig& config, Clock now, Sink sink, const PortOpener& open = openPort);

  void tick();
  void stop() { port_.close(); }

  DeviceStatus& status() { return status_; }
  int baud() const { return bauds_.all[bauds_.at]; }  ///< [bit/s] of the owner's thread: where it is or is looked for

 private:
  void begin(Timestamp now);
  bool receive(Timestamp now);
  void take(const ImuSample& sample);
  void countRejects();
  void watch(Timestamp now);
  void watchSamples(Timestamp now);
  bool tryNextBaud(Timestamp now);
  void giveUp(Timestamp now);
  bool isRecognised() const;
  Problem about(const ProblemKind& kind) const;

  const ImuFacts& facts_;
  /// Baud rates at which it may be.
  struct Bauds {
    std::array<int, ImuFacts::kMostBauds> all{};  // [bit/s]
    std::size_t count = 1;
    std::size_t at = 0, other = 0;       // the present one; the last one but that at which the unit is known
    std::size_t tried = 0;               // since it was understood
    std::optional<std::size_t> known{};  // where it was understood last: every second attempt is there
    /// @return false when all have been tried
    bool next() {
      const bool is_other = !known || at == *known;
      if (is_other) other = (other + 1) % count, ++tried;
      at = is_other ? other : *known;
      return tried < count;
    }
  } bauds_;
  Clock now_;
  Sink sink_;
  DeviceStatus status_;
  DevicePort port_;
  std::unique_ptr<ImuProtocol> protocol_;
  ImuProtocol::Take take_;  // made once: no allocation later
  /// What was received last, and when.
  struct Received {
    Timestamp opened{}, frame{}, sample{}, changed{}, asked{};
    bool noise = false;        // bytes have come since the last frame
    std::uint32_t frames = 0;  // of the protocol at the opening, and ...
    std::uint32_t last = 0;    // ... at the last look
    std::uint32_t damage = 0;  // the same
    bool senseless = false;    // something was rejected since the last sample
    bool has_sample = false;
    ImuSample value{};
  } received_;
};

}  // namespace slam
