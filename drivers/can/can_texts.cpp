// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_texts.hpp"

#include <cstdio>

namespace slam {

using can::odrive::AxisState;

CanTexts::CanTexts(const std::string& interface, const std::array<int, 2>& nodes, bool commands)
    : gone("interface " + interface + " is gone: adapter unplugged?"),
      down(interface + " is down: ip link set " + interface + " up"),
      bus_off(interface + " is bus-off: check wiring and termination"),
      passive(interface + " is error-passive: check wiring, termination and bit rate"),
      unsupported("the kernel has no CAN: modprobe can-raw"),
      refused("the system refuses a CAN socket on " + interface),
      blocked(
          interface +
          " takes no frames, although frames come in: the wheels keep their last speeds until the drives' own "
          "watchdogs stop them; slamd goes on trying; fix: if they turn, cut the drives' power; plug the adapter in "
          "anew, or sudo ip link set " +
          interface + " down && sudo ip link set " + interface + " up"),
      opening_wheels("waiting for the wheels' first frames"),
      opening_imu("waiting for the IMU's first frames"),
      no_imu("no frames of the IMU (005, 032, 034): check its power and the bit rate"),
      no_rate("the IMU sends no rate of turn (032): set its output"),
      no_acceleration("the IMU sends no acceleration (034): its turn rate is used without; set its output"),
      no_time(
          "the IMU sends no sample time (005): its readings are used with the stamps of their arrival; set its output"),
      senseless_imu("the IMU's frames do not make samples: see the rejects"),
      frozen_imu("the IMU answers, but its values never change: restart it"),
      senseless("what the wheels send is no motion of a wheel: see the rejects"),
      rare_time(
          "the IMU sends fewer sample times (005) than turn rates (032): its readings are used with the stamps of "
          "their arrival; set both to one rate"),
      rare_acceleration(
          "the IMU sends fewer accelerations (034) than turn rates (032): each turn rate is used, "
          "without acceleration; set both to one rate") {
  constexpr std::array<const char*, 2> kSides = {"left", "right"};
  std::array<std::string, 2> wheel;
  for (std::size_t i = 0; i < 2; ++i) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%s wheel (node 0x%02x)", kSides[i], static_cast<unsigned>(nodes[i]));
    wheel[i] = name.data();
    const std::string stops = "; slamd stops both wheels until both drives obey and a new SLAM_DRIVE comes; fix: ";
    const auto command = [&](can::odrive::Command which, const char* data) {
      std::array<char, 16> id{};
      std::snprintf(id.data(), id.size(), "%03x#", static_cast<unsigned>(can::odrive::idOf(nodes[i], which)));
      return "cansend " + interface + " " + id.data() + data;
    };
    const std::string arm = command(can::odrive::Command::kSetAxisState, "08000000");
    const auto remedy = [&](const std::string& fix) { return commands ? stops + fix : std::string(); };
    remedy_[i] = remedy("remove the cause, then " + command(can::odrive::Command::kClearErrors, "") + " and " + arm);
    no_frames[i] = "no frames of the " + wheel[i] + remedy("check the drive's power and its plug");
    no_estimates[i] = "the " + wheel[i] + " sends heartbeats, but no encoder estimates: set their rate";
    bad_estimates[i] = "the " + wheel[i] +
                       " sends encoder estimates that are no numbers: slamd uses none of them and goes on without; "
                       "restart the drive, calibrate its encoder anew (odrivetool: dump_errors), and check its cable";
    no_heartbeat[i] = "no heartbeat of the " + wheel[i] + remedy("set the drive's heartbeat_msg_rate_ms to 100");
    frozen[i] = "the " + wheel[i] + " says that it turns, but its position never changes: check its encoder";
    not_closed_loop[i] = "the " + wheel[i] + " is not in closed loop: it obeys no commands" + remedy("arm it: " + arm);
    not_following[i] =
        "the " + wheel[i] +
        " does not turn while the other one does as it is asked to: it is blocked, or its drive is not "
        "in velocity control; slamd stops both wheels until SLAM_DRIVE has paused for 2 s; fix: free the "
        "wheel, " +
        command(can::odrive::Command::kControllerMode, "0200000001000000");
    shared_id[i] = "the heartbeat of the " + wheel[i] +
                   " has the IMU's quaternion's id: it is not heard, the wheel is used; switch the quaternion off, or "
                   "give the drive node 16";
    slow_[i] = "the " + wheel[i] +
               " sends encoder estimates seldom: they are used, the pose is coarser between them; set "
               "encoder_msg_rate_ms to 10 to 50";
    axis_error_[i] = "the " + wheel[i] + " has axis errors" + remedy_[i];
  }
  no_wheels = "no frames of the " + wheel[0] + ", nor of the " + wheel[1] +
              ": check their power, the bit rate and can.left_node, can.right_node";
}

const char* CanTexts::slow(std::size_t side, Duration period) {
  constexpr Duration kStep = std::chrono::milliseconds(10);
  period = (period + kStep / 2) / kStep * kStep;
  for (std::size_t i = 0; i < slow_count_; ++i) {
    if (slow_texts_[i].side == side && slow_texts_[i].period == period) return slow_texts_[i].text.data();
  }
  if (slow_count_ == slow_texts_.size()) return slow_[side].c_str();
  SlowText& entry = slow_texts_[slow_count_++];
  entry.side = side;
  entry.period = period;
  std::snprintf(
      entry.text.data(), entry.text.size(),
      "%s wheel: encoder estimates come every %lld ms: they are used as far as they agree, the pose is coarser; set "
      "encoder_msg_rate_ms to 10 to 50",
      side == 0 ? "left" : "right", static_cast<long long>(period / std::chrono::milliseconds(1)));
  return entry.text.data();
}

const char* CanTexts::link(CanLinkState state) const {
  switch (state) {
    case CanLinkState::kGone:
      return gone.c_str();
    case CanLinkState::kUnsupported:
      return unsupported.c_str();
    case CanLinkState::kRefused:
      return refused.c_str();
    case CanLinkState::kDown:
      return down.c_str();
    case CanLinkState::kBusOff:
      return bus_off.c_str();
    case CanLinkState::kErrorPassive:
      return passive.c_str();
    case CanLinkState::kUp:
      break;
  }
  return "";
}

const char* CanTexts::axis(std::size_t side, const can::odrive::Heartbeat& heartbeat) {
  can::odrive::Heartbeat key = heartbeat;
  key.trajectory_done = false;
  for (std::size_t i = 0; i < axis_count_; ++i) {
    if (axis_texts_[i].side == side && axis_texts_[i].heartbeat == key) return axis_texts_[i].text.data();
  }
  if (axis_count_ == axis_texts_.size()) return axis_error_[side].c_str();
  AxisText& entry = axis_texts_[axis_count_++];
  entry.side = side;
  entry.heartbeat = key;
  const bool armed = key.state == static_cast<std::uint8_t>(AxisState::kClosedLoop);
  std::snprintf(entry.text.data(), entry.text.size(), "%s wheel: axis error 0x%x%s%s%s, %s%s",
                side == 0 ? "left" : "right", static_cast<unsigned>(key.axis_error), key.motor_error ? ", motor" : "",
                key.encoder_error ? ", encoder" : "", key.controller_error ? ", controller" : "",
                armed ? "still in closed loop" : "disarmed", remedy_[side].c_str());
  return entry.text.data();
}

}  // namespace slam
