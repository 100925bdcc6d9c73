// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/rplidar_unit.hpp"

namespace slam {

using namespace std::chrono_literals;
using rplidar::HealthStatus;
using rplidar::Request;

/// The port is there, so ask the unit how it is before giving up.
Problem RplidarUnit::silence(const LidarReader& scan) {
  constexpr Duration kLastQuestion = 250ms;  // to a silent unit; a boot is over by then
  const bool undecodable = scan.nodes() == 0 && scan.bytes() > 0;
  if (undecodable) ++passed_over_;
  dialogue_->send(rplidar::encodeRequest(Request::kStop));
  dialogue_->drain(kAfterStop, 2 * kAfterStop);
  const auto health = askHealth(kLastQuestion);
  if (dialogue_->hungUp()) return problem::kPortGone;
  if (dialogue_->sawBoot()) return problem::kLidarRestarted;
  if (!health) return problem::kLidarSilent;
  if (health->status == HealthStatus::kError) return problem::kLidarError;
  if (undecodable) return problem::kLidarGarbage;
  if (scan.nodes() == 0) return problem::kLidarMotorStands;
  return problem::kLidarIdle;
}

void RplidarUnit::end() {
  if (port_ == nullptr) return;
  port_->write(rplidar::encodeRequest(Request::kStop));
  port_->rest(5ms);  // a request right behind STOP is lost
  setMotor(false);
  dialogue_.reset();
  port_ = nullptr;
}

void RplidarUnit::setMotor(bool on) {
  constexpr std::uint16_t kMotorPwm = 660;    // about 10 turns a second
  constexpr std::uint16_t kMotorSpeed = 600;  // [rpm] ten turns a second
  if (motor_by_pwm_) port_->write(rplidar::encodeMotorPwm(on ? kMotorPwm : 0));
  if (motor_by_speed_) port_->write(rplidar::encodeMotorSpeed(on ? kMotorSpeed : 0));
  port_->setDtr(!on);  // the A1's adapter inverts it
}

}  // namespace slam
