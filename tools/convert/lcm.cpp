// SPDX-License-Identifier: BSD-3-Clause
#include <slam/config_t.hpp>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/received.hpp"
#include "tools/convert/assembler.hpp"
#include "tools/convert/formats.hpp"

namespace slam {
namespace {

/// slamd's own messages go as they are, but for those that are no measurement.
class OwnLog : public Reader {
 public:
  using Reader::Reader;

  void read(Assembler& to) override {
    EventLogReader log(in_);
    for (LogEvent event; log.next(event);) {
      const std::string& name = event.channel;
      const Origin at{.sensor = name,
                      .where = in_.filename().string() + " " + name,
                      .received = event.utime,
                      .message = event.data};
      if (name == channel::kScan) {
        use<scan_t>(at, to, [&](const Origin& from, auto& scan) { to.scan(from, scan, {.timed = spanOf(scan) > 0}); });
      } else if (name == channel::kWheels) {
        use<wheels_t>(at, to, [&](const Origin& from, const auto& wheels) { to.wheels(from, wheels.T_wheels_base); });
      } else if (name == channel::kImu) {
        use<imu_t>(at, to, [&](const Origin& from, const auto& imu) { to.imu(from, imu.gyro, imu.accel); });
      } else if (name == channel::kConfig) {
        const auto message = decodeChecked<config_t>(event.data);
        if (message && !to.recording.configuration) to.recording.configuration = message->configuration;
      } else {
        constexpr std::size_t kMostChannels = 1000;
        to.passOver(name, kMostChannels);
      }
    }
  }

  void finish(Assembler& to) override {
    to.recording.format = "LCM log";
    to.noteChannels();
    if (to.recording.scans == 0) {
      throw std::runtime_error(in_.string() +
                               ": an LCM log without scans that are known (SLAM_SCAN, or lidar_t of a Maebot or MBot)");
    }
  }

 private:
  template <typename Message, typename Body>
  static void use(Origin at, Assembler& to, const Body& body) {
    Received<Message> received(at.message);
    if (!received) return to.refuse(at, problemOf(received.refusal, at.sensor).words());
    at.stamp = received.message->utime;
    body(at, *received.sample);
  }
};

}  // namespace

Recording convertLcm(const std::filesystem::path& in, const std::filesystem::path& out) {
  return assemble(OwnLog(in), out);
}

}  // namespace slam
