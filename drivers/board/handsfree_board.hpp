// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/samples.hpp"
#include "drivers/base/wheel_angles.hpp"
#include "drivers/device_status.hpp"
#include "drivers/latest_triple.hpp"
#include "drivers/polled_port.hpp"
#include "drivers/speaker.hpp"
#include "drivers/speed_command.hpp"
#include "firmware_if/robolink.hpp"
#include "timing/refresh_clock.hpp"

namespace slam {

struct HandsfreeConfig {
  std::string port = {};
  int baud = 921600;           ///< [bit/s]
  double mileage_rate = 50.0;  ///< [Hz] the mean; below the board's own rate the stamps cannot be sharp
  double imu_rate = 100.0;     ///< [Hz] the same
  double sample_age = 0.010;   ///< [s] of the board's values when it answers, until their true age has been found out
  robolink::ChassisType chassis = robolink::ChassisType::kDifferential2;
  double wheel_radius = 0.0;   ///< [m] believed here, compared with the board's; 0: not compared
  double body_radius = 0.0;    ///< [m] the same; half the track of a differential base
  bool may_drive = false;      ///< false: command() does nothing
  SpeedLimits limits{};        ///< of what it commands
  bool in_background = false;  ///< the port is opened by a thread of its own
};

/// Speeds of the wheels as the board measures them, in the same order and sign.
struct WheelSpeeds {
  Timestamp stamp;                 ///< when asked: up to 50 ms late
  std::array<double, 4> speeds{};  ///< [rad/s]
  int count = 2;
};

/// Owns a HandsFree controller board: polls wheels and IMU over RoboLink, answers its handshake, survives its resets.
///
/// To be ticked at a fixed rate by one thread; a tick never waits, but for opening the port when
/// there is none. At most one request is under way. Stamps are sharp (below 1 ms) when the tick's rate is no multiple
/// of the board's 50 Hz, e.g. 211 Hz; at 200 Hz all requests meet the same few phases of the board.
class HandsfreeBoard {
 public:
  struct Sinks {
    std::function<void(const WheelAngles&)> wheels;
    std::function<void(const ImuSample&)> imu = nullptr;       ///< not asked for where there is none
    std::function<void(const WheelSpeeds&)> speeds = nullptr;  ///< asked for at 10 Hz where there is one
  };
  using Clock = Timestamp (*)();

  HandsfreeBoard(const HandsfreeConfig& config, Clock now, Sinks sinks, const PortOpener& open = openPort);
  ~HandsfreeBoard() { stop(); }

  void tick();
  /// Stops the robot if it may drive, waiting for the board's answer up to a tenth of a second; closes the port.
  void stop();

  // From any one other thread, without waiting:

  /// Pose of base [m, m, rad] that a board is told after its reset, so that its own odometry goes on from there.
  void setCoordinate(double x, double y, double theta) { coordinate_.store({{x, y, theta}, 1}); }
  /// What local time is ahead of our clock, so that the board can be told the time at its handshake.
  void setLocalTimeOffset(Duration offset) { local_time_offset_ = offset.count(); }
  /// Drives the robot with a twist [m/s, m/s, rad/s], within the limits and as long as a SpeedCommand lasts: to be
  /// called again and again. Then a stop is owed, as it is when the port was opened, an answer did not come or the
  /// board has begun anew: a zero that the board acknowledges. @param given when; not later than now
  /// @return false when not allowed or not finite
  bool command(double vx, double vy, double omega, Timestamp given);
  bool command(double vx, double vy, double omega) { return command(vx, vy, omega, now_()); }

  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  float battery() const { return battery_; }           ///< [V]; 0: not known yet
  float boardTime() const { return board_time_; }      ///< [s] since the board's start, coarse; 0: not known yet
  float wheelRadius() const { return wheel_radius_; }  ///< [m] that the board believes in; 0: not known yet
  float bodyRadius() const { return body_radius_; }    ///< [m] the same
  std::uint64_t limitedSpeeds() const { return speeds_.limited(); }  ///< that were asked for above the limits
  Problem finding() const { return finding_.load(); }                ///< what board and configuration disagree on

 private:
  struct Poll {
    robolink::Command command;
    PollSchedule schedule;
  };
  static constexpr Duration kRenewed = std::chrono::milliseconds(50);  // the longer of the board's periods

  /// What was read last, and when it was asked for in vain.
  template <typename Values>
  struct PolledRegister {
    std::optional<Values> values;
    Timestamp asked{}, changed{}, used{};  // last request with these values, first one; the last handed on
    RefreshClock clock;

    /// When the values were taken that have just been answered and are others than before: until the clock knows,
    /// in the middle between the requests that got the old and the new ones.
    /// @return nullopt: these are so far apart that a difference to the values used last would tell a wrong speed
    std::optional<Timestamp> taken(Timestamp requested, Timestamp answered) {
      if (!values) return std::nullopt;
      const auto taken = clock.stamp({asked, requested, answered});
      const Duration within = answered - asked;
      if (taken || (within > kRenewed && 2 * within > answered - used)) return taken;
      return asked + within / 2;
    }
  };

  void open(Timestamp now);
  void close(Timestamp now, DeviceState state, const Problem& why);
  bool receive(Duration wait = Duration(0));
  void handle(const robolink::Frame& frame);
  bool handleAnswer(robolink::Command command, std::span<const std::uint8_t> payload);
  template <typename Value>
  bool use(const std::optional<Value>& value, void (HandsfreeBoard::*handler)(const Value&));
  void handleMileage(const robolink::MotorVector& mileage);
  void handleImu(const robolink::Imu& imu);
  void handleInfo(const robolink::SystemInfo& info);
  void handleChassis(const robolink::ChassisParameters& chassis);
  void handleSpeeds(const robolink::MotorVector& speeds);
  void greet();
  void sendCoordinate();
  void request(Timestamp now);
  bool requestDrive(Timestamp now);
  bool requestOnce(Timestamp now);
  void ask(Timestamp now, robolink::Command command, std::span<const std::uint8_t> payload = {});
  void send(robolink::Command command, std::span<const std::uint8_t> payload = {});
  void setBoth(DeviceState state, const Problem& why);
  void watch(Timestamp now);
  bool impossible(const robolink::MotorVector& mileage) const;
  std::array<double, 4> forward(const robolink::MotorVector& motors) const;

  HandsfreeConfig config_;
  Clock now_;
  Sinks sinks_;
  int wheel_count_;
  DeviceStatus wheels_, imu_;
  PolledPort port_;
  WrongSpeaker wrong_speaker_;
  robolink::Decoder decoder_;
  std::array<Poll, 4> polls_;
  std::optional<robolink::Command> pending_;
  Timestamp requested_{}, answered_{};
  PolledRegister<robolink::MotorVector> mileage_;
  PolledRegister<robolink::Imu> last_imu_;
  bool restarted_ = true;
  bool bytes_came_ = false;        // since the last answer
  bool drained_ = true;            // no answer to a request given up before can still come
  std::optional<Timestamp> late_;  // of the last answer to a request given up before
  std::uint32_t unanswered_ = 0, bad_mileage_ = 0;
  int chassis_tries_left_ = 0;
  Timestamp next_chassis_{}, next_clear_{};
  float last_system_time_ = 0.0F;  // [us]
  Timestamp time_asked_{};
  int still_looks_ = 0;  // at its time, one after the other without progress
  bool time_ran_ = false, frozen_ = false;
  LatestTriple coordinate_;
  SpeedDuty speeds_;
  std::atomic<std::int64_t> local_time_offset_{0};  // [ns]; 0: not known
  std::atomic<float> battery_{0.0F}, board_time_{0.0F}, wheel_radius_{0.0F}, body_radius_{0.0F};
  SharedProblem finding_;
};

}  // namespace slam
