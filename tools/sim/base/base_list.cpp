// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <stdexcept>

#include "drivers/base/base_facts.hpp"
#include "drivers/search/driver_row.hpp"
#include "tools/sim/base/counting_base.hpp"
#include "tools/sim/board/board_emulator.hpp"

namespace slam::sim {
namespace {

/// A HandsFree board as slam-sim's robot has it.
class HandsfreeBase : public EmulatedBase {
 public:
  void renew(RobotModel& robot, Timestamp now) override {
    constexpr Duration kPeriod = std::chrono::milliseconds(20);         // of the IMU's values ...
    constexpr Duration kMileagePeriod = std::chrono::milliseconds(50);  // ... and of the mileage, as the open firmware
    if (started_ == Timestamp{}) started_ = next_ = next_mileage_ = now;
    if (now < next_) return;
    next_ += kPeriod;
    if (now >= next_mileage_) {
      next_mileage_ += kMileagePeriod;
      mileage_ = robot.encoderAngles();
    }
    const ImuReading reading = robot.readImu();
    robolink::Imu imu;
    for (std::size_t i = 0; i < 3; ++i) {
      imu.gyro[i] = static_cast<float>(reading.gyro[i]);
      imu.accel[i] = static_cast<float>(reading.accel[i]);
    }
    board_.renew(mileage_[0], mileage_[1], imu, toSeconds(now - started_));
  }
  void exchange(std::span<const std::uint8_t> in, Timestamp now, Bytes& out) override {
    if (started_ != Timestamp{}) board_.receive(in, toSeconds(now - started_), out);
  }
  bool inject(std::string_view kind, double value) override { return board_.inject(kind, value); }
  bool inUse() const override { return board_.greeted(); }
  Twist2 drive() const override {
    const Eigen::Vector3d twist = board_.drive();
    return {twist.x(), 0.0, twist.z()};
  }

 private:
  BoardEmulator board_{kinematicsOf(kNominalBase)};
  std::array<double, 2> mileage_{};  // [rad] as the board has copied it last
  Timestamp started_{}, next_{}, next_mileage_{};
};

struct Row {
  const char* driver;
  std::unique_ptr<EmulatedBase> (*make)();
};
constexpr std::array kRows = {
    Row{"handsfree", []() -> std::unique_ptr<EmulatedBase> { return std::make_unique<HandsfreeBase>(); }},
    Row{"text", makeArduino},
    Row{"create", makeCreate},
    Row{"kobuki", makeKobuki},
    Row{"frame", makeFrameBase},
    Row{"roboclaw", makeRoboclaw},
    Row{"opencr", makeOpencr},
    Row{"vesc", makeVesc}};

}  // namespace

std::unique_ptr<EmulatedBase> makeBase(std::string_view driver) {
  const Row* row = rowOfDriver<Row>(kRows, driver);
  if (row == nullptr) throw std::invalid_argument("no base " + std::string(driver) + " is simulated");
  return row->make();
}

std::vector<std::string> baseNames() {
  std::vector<std::string> names;
  for (const Row& row : kRows) names.emplace_back(row.driver);
  return names;
}

SimulatedGeometry geometryOf(std::string_view driver) {
  const BaseFacts* facts = findBase(driver);
  SimulatedGeometry geometry{kNominalBase, kCountsPerTurn};
  if (facts == nullptr) return geometry;
  if (facts->wheel_radius > 0.0) geometry.base = {facts->wheel_radius, facts->half_track};
  if (facts->counts_per_turn > 0.0) geometry.counts_per_turn = facts->counts_per_turn;
  return geometry;
}

}  // namespace slam::sim
