// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/samples.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "firmware_if/robolink.hpp"

namespace slam {

struct HandsfreeConfig {
  std::string port;
  int baud = 921600;           ///< [bit/s]
  double mileage_rate = 50.0;  ///< [Hz]
  double imu_rate = 100.0;     ///< [Hz]
  double sample_age = 0.010;   ///< [s] mean age of the board's values when it answers
};

/// Accumulated angles of the driven wheels.
struct WheelAngles {
  Timestamp stamp;
  double left = 0.0, right = 0.0;  ///< [rad] positive driving forward
  bool restarted = false;          ///< the board began to count anew: no difference to the reading before
};

/// Owns a HandsFree controller board: polls mileage and IMU over RoboLink, answers its handshake, survives its resets.
///
/// To be ticked at a fixed rate by one thread; a tick never waits, but for opening the port when
/// there is none. At most one request is under way.
class HandsfreeBoard {
 public:
  struct Sinks {
    std::function<void(const WheelAngles&)> wheels;
    std::function<void(const ImuSample&)> imu;
  };
  using Clock = Timestamp (*)();

  HandsfreeBoard(const HandsfreeConfig& config, Clock now, Sinks sinks);

  void tick();
  void stop() { stream_.reset(); }

  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  float battery() const { return battery_; }  ///< [V]; 0: not known yet

 private:
  struct Poll {
    robolink::Command command;
    Duration period;
    Timestamp due;
  };

  void open(Timestamp now);
  void close(Timestamp now, DeviceState state, const char* reason);
  bool receive();
  void handle(const robolink::Frame& frame);
  void handleMileage(const robolink::MotorVector& mileage);
  void handleImu(const robolink::Imu& imu);
  void request(Timestamp now);
  void send(robolink::Command command, std::span<const std::uint8_t> payload = {});
  void setBoth(DeviceState state, const char* reason);
  void watch(Timestamp now);

  HandsfreeConfig config_;
  Clock now_;
  Sinks sinks_;
  DeviceStatus wheels_, imu_;
  std::unique_ptr<ByteStream> stream_;
  robolink::Decoder decoder_;
  std::array<Poll, 3> polls_;
  std::optional<robolink::Command> pending_;
  Timestamp requested_{}, answered_{}, next_open_{};
  Duration back_off_{0};
  std::optional<robolink::MotorVector> mileage_;
  std::optional<robolink::Imu> last_imu_;
  Timestamp mileage_changed_{};
  bool restarted_ = true;
  std::uint32_t unanswered_ = 0;  // requests
  std::atomic<float> battery_{0.0F};
};

}  // namespace slam
