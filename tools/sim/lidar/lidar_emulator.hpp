// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "tools/sim/lidar/emulated_lidar.hpp"
#include "tools/sim/lidar/lidar_encoder.hpp"
#include "tools/sim/lidar/lidar_faults.hpp"
#include "tools/sim/lidar/lidar_identity.hpp"
#include "tools/sim/lidar/other_lidar.hpp"

namespace slam::sim {

/// An RPLidar at byte level: answers requests as its identity does, streams standard nodes or capsules byte by byte as
/// the line carries them. Pure: time and ranges come from outside.
class LidarEmulator : public EmulatedLidar {
 public:
  /// @param turn_rate [1/s]
  LidarEmulator(Measure measure, double turn_rate, LidarIdentity identity = a1Firmware129());

  void receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out) override;
  void stream(Timestamp now, std::vector<std::uint8_t>& out) override;
  bool inject(std::string_view kind, double value) override { return faults_.inject(kind, value); }
  bool scanning() const override { return sampler_.isOn(); }
  std::uint16_t pwm() const { return pwm_; }      ///< of the motor, 0..1023
  std::uint16_t speed() const { return speed_; }  ///< [rpm] asked for of the motor of an S unit

 private:
  /// What the turning mirror takes, and the packets that it makes of that.
  class Sampler {
   public:
    /// What a sample at a moment sees, by the clockwise angle [deg].
    using LookAt = std::function<LidarEncoder::Look(Timestamp)>;
    explicit Sampler(double turn_rate) : turn_rate_(turn_rate) {}

    void begin(rplidar::AnswerType type, std::size_t packet_samples, Duration sample_time, Timestamp now);
    void end() { encoder_.reset(); }
    bool isOn() const { return encoder_.has_value(); }
    void setTurnRate(double turn_rate) { turn_rate_ = turn_rate; }  ///< [1/s]
    void resetEncoder();
    /// Time goes on, and mostly the mirror, but no samples are taken.
    void skipTo(Timestamp now);
    /// When the next packet leaves.
    Timestamp due() const;
    /// @param stuck it shows the turn before again
    std::vector<std::uint8_t> makePacket(bool stuck, const LookAt& look_at);
    bool isCapsule() const { return packet_samples_ > 1; }

   private:
    Timestamp taken(std::int64_t sample) const { return started_ + sample * sample_time_; }
    void take(bool stuck, const LookAt& look_at);

    double turn_rate_;
    std::optional<LidarEncoder> encoder_;  // while it scans
    std::size_t packet_samples_ = 0, needed_samples_ = 0;
    Duration sample_time_{};
    Timestamp started_{};
    std::int64_t sample_ = 0;  // next one to take
    double angle_ = 0.0;       // [turns] of that, clockwise
    bool s_bit_ = false, first_of_turn_ = false;
    std::vector<LidarEncoder::Sample> samples_;           // not sent yet
    std::vector<LidarEncoder::Sample> turn_, last_turn_;  // this one, and the one before
    bool repeating_ = false;
  };

  /// @return false: the request is not for the motor
  bool setMotor(rplidar::Request request, std::span<const std::uint8_t> payload, Timestamp now);
  void handle(Timestamp now, std::vector<std::uint8_t>& out);
  void answer(rplidar::AnswerType type, const std::vector<std::uint8_t>& data, std::vector<std::uint8_t>& out);
  void answerConfiguration(std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& out);
  void startScan(rplidar::AnswerType type, double sample_us, Timestamp now, std::vector<std::uint8_t>& out);
  void boot(Timestamp now);
  void beginFaults(Timestamp now);
  bool turning(Timestamp now) const;
  bool hasSpeedControl() const { return identity_.model >> 4 >= 6; }
  void makePackets(Timestamp now, std::vector<std::uint8_t>& out);
  void sendOn(Timestamp now, std::vector<std::uint8_t>& out);

  Measure measure_;
  Sampler sampler_;
  LidarIdentity identity_;
  LidarFaults faults_;
  Duration byte_time_;
  std::vector<std::uint8_t> request_;  // bytes of an unfinished one
  Timestamp request_begin_{};
  std::uint16_t pwm_ = 0, speed_ = 0;
  OtherLidar other_;
  Timestamp stable_at_{}, ready_at_{}, paused_until_{};  // motor at speed; boot over; no data until then
  std::deque<std::uint8_t> line_;                        // bytes that are on their way
  Timestamp line_begin_{};                               // when the first of them begins
};

}  // namespace slam::sim
