// SPDX-License-Identifier: BSD-3-Clause
// The driver of the board against each fault of the emulated board, over a pseudo-terminal.
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "drivers/board/handsfree_board.hpp"
#include "drivers/pseudo_terminal.hpp"
#include "tools/sim/board/board_emulator.hpp"

namespace slam::sim::board_faults_test {
namespace {

using namespace std::chrono_literals;

/// Time that passes only when a test says so.
Timestamp virtual_now{1000s};
Timestamp virtualNow() { return virtual_now; }

class DrivenBoard : public testing::Test {
 protected:
  void runFor(Duration time) {
    for (const Timestamp end = virtual_now + time; virtual_now < end;) {
      virtual_now += std::chrono::nanoseconds(1'000'000'000 / 211);
      const double uptime = toSeconds(virtual_now - start_);
      for (; next_ <= virtual_now; next_ += 20ms) {
        angle_ += 0.05;
        noise_ = -noise_;
        board_.renew(angle_, 2.0 * angle_, {.gyro = {0.0F, 0.0F, noise_}, .accel = {0.0F, 0.0F, 9.8F}}, uptime);
      }
      driver_.tick();
      std::vector<std::uint8_t> out;
      board_.receive(line_.received(), uptime, out);
      if (out.empty()) continue;
      line_.write(out);
    }
  }
  bool streaming() {
    return driver_.wheelStatus().state == DeviceState::kStreaming &&
           driver_.imuStatus().state == DeviceState::kStreaming;
  }
  static std::string words(DeviceStatus& status) { return status.problem().words(); }

  test::PseudoTerminal line_;
  BoardEmulator board_;
  Timestamp start_ = virtual_now, next_ = virtual_now;
  double angle_ = 0.0;    // [rad]
  float noise_ = 0.001F;  // [rad/s]
  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  HandsfreeBoard driver_{{.port = line_.path(), .may_drive = true},
                         virtualNow,
                         {.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); },
                          .imu = [this](const ImuSample& sample) { imu_.push_back(sample); }},
                         line_.opener()};
};

struct Fault {
  const char* kind;
  double on, off;
  const char* imu;     // what the IMU's status says
  const char* wheels;  // and that of the wheels; "": streaming
};

TEST_F(DrivenBoard, ReportsWhatEachFaultIsAndStreamsAgainAfterIt) {
  const Fault faults[] = {
      {"silent", 1, 0, "does not answer", "does not answer"},
      {"garbage", 1, 0, "cannot be read", "cannot be read"},
      {"checksum", 1000, 0, "cannot be read", "cannot be read"},
      {"stuck", 1, 0, "renews nothing", "renews nothing"},
      {"imu_offline", 1, 0, "IMU is offline", ""},
      {"slow", 250, 0, "too late", "too late"},
  };
  runFor(3s);
  ASSERT_TRUE(streaming());
  for (const Fault& fault : faults) {
    ASSERT_TRUE(board_.inject(fault.kind, fault.on));
    runFor(2800ms);  // a frozen board shows at its time, asked for once a second
    EXPECT_NE(words(driver_.imuStatus()).find(fault.imu), std::string::npos)
        << fault.kind << ": " << words(driver_.imuStatus());
    EXPECT_NE(words(driver_.wheelStatus()).find(fault.wheels), std::string::npos)
        << fault.kind << ": " << words(driver_.wheelStatus());
    ASSERT_TRUE(board_.inject(fault.kind, fault.off));
    runFor(3s);
    EXPECT_TRUE(streaming()) << fault.kind << ": " << words(driver_.wheelStatus());
  }
  for (std::size_t i = 1; i < wheels_.size(); ++i) EXPECT_FALSE(wheels_[i].restarted) << "the way was counted on";
  EXPECT_NEAR(wheels_.back().angles[0], angle_, 0.2);
}

TEST_F(DrivenBoard, ResetCostsTheWayInBetweenAndNoJump) {
  runFor(2s);
  const std::size_t before = wheels_.size();
  ASSERT_TRUE(board_.inject("reset", 1));
  runFor(500ms);
  ASSERT_GT(wheels_.size(), before + 5);
  // An answer that was under way when the board was reset still counts on.
  const std::size_t first = wheels_[before].restarted ? before : before + 1;
  EXPECT_TRUE(wheels_[first].restarted);
  EXPECT_LT(wheels_[first].angles[0], 1.0);
  EXPECT_TRUE(streaming());
}

TEST_F(DrivenBoard, AFewWrongChecksumsAreCountedAndCostNothingElse) {
  runFor(2s);
  const std::int64_t rejects = driver_.wheelStatus().rejects;
  ASSERT_TRUE(board_.inject("checksum", 3));
  runFor(1s);
  EXPECT_GE(driver_.wheelStatus().rejects, rejects + 3);
  EXPECT_TRUE(streaming());
}

TEST_F(DrivenBoard, IsMovedByCommandsAndStoppedWithoutThem) {
  runFor(1s);
  for (int i = 0; i < 20; ++i) {
    driver_.command(0.25, 0.0, -0.5);
    runFor(50ms);
  }
  EXPECT_TRUE(board_.drive().isApprox(Eigen::Vector3d(0.25, 0.0, -0.5)));
  runFor(1s);
  EXPECT_EQ(board_.drive().norm(), 0.0);
}

}  // namespace
}  // namespace slam::sim::board_faults_test
