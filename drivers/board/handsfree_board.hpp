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
#include "drivers/line_device.hpp"
#include "drivers/polled_port.hpp"
#include "drivers/speed_command.hpp"
#include "firmware_if/robolink.hpp"
#include "timing/refresh_clock.hpp"

namespace slam {

struct HandsfreeConfig {
  std::string port = {};
  int baud = robolink::kBaud;  ///< [bit/s]
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
  void setCoordinate(double x, double y, double theta) { host_.setCoordinate({x, y, theta}); }
  /// What local time is ahead of our clock, so that the board can be told the time at its handshake.
  void setLocalTimeOffset(Duration offset) { host_.setLocalTimeOffset(offset); }
  /// Drives the robot with a twist [m/s, m/s, rad/s], within the limits and as long as a SpeedCommand lasts: to be
  /// called again and again. Then a stop is owed, as it is when the port was opened, an answer did not come or the
  /// board has begun anew: a zero that the board acknowledges. @param given when; not later than now
  /// @return false when not allowed or not finite
  bool command(double vx, double vy, double omega, Timestamp given);
  bool command(double vx, double vy, double omega) { return command(vx, vy, omega, now_()); }

  DeviceStatus& wheelStatus() { return wheels_; }
  DeviceStatus& imuStatus() { return imu_; }
  float battery() const { return report_.battery(); }          ///< [V]; 0: not known yet
  float wheelRadius() const { return report_.wheelRadius(); }  ///< [m] that the board believes in; 0: not known yet
  float bodyRadius() const { return report_.bodyRadius(); }    ///< [m] the same
  std::uint64_t limitedSpeeds() const { return speeds_.limited(); }  ///< that were asked for above the limits
  Problem finding() const { return report_.finding(); }              ///< what board and configuration disagree on

 private:
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

  /// The request under way: one at most. Answers carry no number, and one that comes late must not pass for that of the
  /// next request. They come in order: when another command has been answered, all before it have been.
  class Request {
   public:
    /// The port was opened.
    void begin(Timestamp now);
    void sent(robolink::Command command, Timestamp now) {
      pending_ = command;
      requested_ = now;
    }
    std::optional<robolink::Frame> push(std::uint8_t byte) {
      bytes_came_ = true;
      return decoder_.push(byte);
    }
    std::optional<robolink::Frame> flush() { return decoder_.flush(); }
    void noteFrame(Timestamp now) {
      answered_ = now;
      bytes_came_ = false;
    }
    /// @return whether it answers the request; else it is late
    bool take(robolink::Command command);
    /// Where the time for an answer is over: the request is lost. @return whether it is
    bool giveUp(Timestamp now);
    /// The board has begun anew.
    void noteRestart() { drained_ = true; }

    const std::optional<robolink::Command>& pending() const { return pending_; }
    Timestamp requested() const { return requested_; }
    Timestamp answered() const { return answered_; }  ///< anything at all
    bool isDrained() const { return drained_; }       ///< no answer to one that was given up can still come
    bool bytesCame() const { return bytes_came_; }    ///< since the last answer
    bool wasLate(Timestamp now) const;                ///< an answer to one that was given up before, lately
    std::uint32_t rejects() const;                    ///< requests without an answer, and damaged frames

   private:
    robolink::Decoder decoder_;
    std::optional<robolink::Command> pending_;
    Timestamp requested_{}, answered_{};
    bool bytes_came_ = false, drained_ = true;
    std::optional<Timestamp> late_;
    std::uint32_t unanswered_ = 0;
  };

  /// The wheels' counters.
  class Mileage {
   public:
    explicit Mileage(robolink::ChassisType chassis);

    /// @param frozen the board renews nothing @param age [s] of its values until their true age is known
    /// @return angles, unless these are no news or would make a wrong speed: then the next difference spans them
    std::optional<WheelAngles> take(const robolink::MotorVector& mileage, const Request& request, bool frozen,
                                    double age);
    WheelSpeeds speeds(const robolink::MotorVector& speeds, Timestamp stamp) const {
      return {stamp, forward(speeds), count_};
    }
    /// What could not be read. Whatever it counts next need not be what it counted before.
    void reject() {
      ++bad_;
      restarted_ = true;
    }
    void restart() {
      last_.clock.restart();
      restarted_ = true;
    }
    std::uint32_t rejects() const { return bad_; }
    /// Whether the wheels stand, at angles where single precision costs.
    bool isCoarse(Timestamp now) const;

   private:
    bool impossible(const robolink::MotorVector& mileage, Timestamp requested, bool frozen) const;
    std::array<double, 4> forward(const robolink::MotorVector& motors) const;

    robolink::ChassisType chassis_;
    int count_;  // of wheels
    PolledRegister<robolink::MotorVector> last_;
    bool restarted_ = true;
    std::uint32_t bad_ = 0;
  };

  /// The board's time: whether it runs on.
  class BoardTime {
   public:
    /// @param time [us] @return whether it stands still
    bool look(float time, Timestamp asked);
    void restart();
    bool isFrozen() const { return frozen_; }

   private:
    float last_ = 0.0F;  // [us]
    Timestamp asked_{};
    int still_looks_ = 0;  // one after the other without progress
    bool ran_ = false, frozen_ = false;
  };

  /// What the host has for a board that begins anew: written by any one thread.
  class Host {
   public:
    void setCoordinate(const std::array<double, 3>& pose) { coordinate_.store({pose, 1}); }
    void setLocalTimeOffset(Duration offset) { local_time_offset_ = offset.count(); }
    const std::array<double, 3>& coordinate() { return coordinate_.load().numbers; }
    robolink::SystemInfo infoAt(Timestamp now) const;

   private:
    LatestTriple coordinate_;
    std::atomic<std::int64_t> local_time_offset_{0};  // [ns]; 0: not known
  };

  /// What the board reports of itself: read by any thread.
  class Report {
   public:
    void take(const robolink::SystemInfo& info);
    void take(const robolink::ChassisParameters& chassis, const HandsfreeConfig& config);
    float battery() const { return battery_; }
    float wheelRadius() const { return wheel_radius_; }
    float bodyRadius() const { return body_radius_; }
    Problem finding() const { return finding_.load(); }

   private:
    std::atomic<float> battery_{0.0F}, wheel_radius_{0.0F}, body_radius_{0.0F};
    SharedProblem finding_;
  };

  /// What is asked, again and again or now and then.
  class Schedule {
   public:
    explicit Schedule(const HandsfreeConfig& config);
    void begin(Timestamp now);
    /// The poll that is due first, of those that somebody wants.
    std::optional<robolink::Command> next(Timestamp now, bool imu, bool speeds);
    bool chassisDue(Timestamp now);
    void noteChassis() { chassis_tries_left_ = 0; }
    bool clearDue(Timestamp now);

   private:
    struct Poll {
      robolink::Command command;
      PollSchedule schedule;
    };
    std::array<Poll, 4> polls_;
    int chassis_tries_left_ = 0;
    Timestamp next_chassis_{}, next_clear_{};
  };

  void begin(Timestamp now);
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
  void watch(Timestamp now);

  HandsfreeConfig config_;
  Clock now_;
  Sinks sinks_;
  DeviceStatus wheels_, imu_;
  DevicePort port_;
  Schedule schedule_;
  Request request_;
  Mileage mileage_;
  PolledRegister<robolink::Imu> last_imu_;
  BoardTime time_;
  Host host_;
  Report report_;
  SpeedDuty speeds_;
};

}  // namespace slam
