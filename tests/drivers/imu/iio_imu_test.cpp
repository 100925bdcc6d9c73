// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_imu.hpp"

#include <gtest/gtest.h>
#include <vector>

#include "drivers/imu/iio_folder.hpp"
#include "problems/devices.hpp"
#include "runtime/clock.hpp"
#include "support/allocations.hpp"
#include "support/wait_until.hpp"

namespace slam::iio_imu_test {
namespace {

class IioImuTest : public testing::Test {
 protected:
  /// Ticks, with another value each time, until the condition holds.
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition, bool changing = true) {
    return test::waitUntil([&] {
      if (changing) folder_.set("in_anglvel_z_raw", std::to_string(500 + ++value_ % 100));
      imu_.tick();
      return condition();
    });
  }
  bool has(const ProblemKind& kind) { return imu_.status().problem().is(kind); }
  bool streams() { return imu_.status().state == DeviceState::kStreaming; }

  test::IioFolder folder_;
  int value_ = 0;
  std::vector<ImuSample> samples_;
  IioImu imu_{{.device = "mpu6050", .rate = 200.0, .root = folder_.root()},
              monotonicNow,
              [this](const ImuSample& sample) { samples_.push_back(sample); }};
};

TEST_F(IioImuTest, HandsOnWhatIsNew) {
  const Timestamp begin = monotonicNow();
  ASSERT_TRUE(runUntil([&] { return samples_.size() > 20; }));
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    EXPECT_GE(samples_[i].stamp, begin);
    EXPECT_LE(samples_[i].stamp, monotonicNow());
    EXPECT_TRUE(i == 0 || samples_[i].stamp > samples_[i - 1].stamp);
    EXPECT_TRUE(i == 0 || samples_[i].gyro != samples_[i - 1].gyro) << "the chip has measured anew";
  }
  EXPECT_TRUE(streams());
}

TEST_F(IioImuTest, NamesItsFaultsAndGoesOnBehindThem) {
  ASSERT_TRUE(runUntil([&] { return streams(); }));
  ASSERT_TRUE(runUntil([&] { return has(problem::kImuFrozen); }, false));
  ASSERT_TRUE(runUntil([&] { return streams(); }));
  folder_.remove("in_anglvel_x_raw");
  ASSERT_TRUE(runUntil([&] { return has(problem::kIioUnread) || has(problem::kIioNoGyro); }));
  folder_.set("in_anglvel_x_raw", "1");
  ASSERT_TRUE(runUntil([&] { return streams(); }));
  folder_.set("in_anglvel_x_raw", "1e12");
  ASSERT_TRUE(runUntil([&] { return has(problem::kImuSenseless); }));
  EXPECT_GT(imu_.status().rejects, 0);
  folder_.set("in_anglvel_x_raw", "1");
  ASSERT_TRUE(runUntil([&] { return streams(); }));
  folder_.unplug();
  ASSERT_TRUE(runUntil([&] { return has(problem::kIioMissing); }, false));
  EXPECT_EQ(imu_.status().state, DeviceState::kAbsent);
  folder_.plug();
  ASSERT_TRUE(runUntil([&] { return streams(); }));
}

TEST_F(IioImuTest, DoesNotAllocateInATick) {
  samples_.reserve(1000);
  ASSERT_TRUE(runUntil([&] { return samples_.size() > 3; }));
  folder_.set("in_anglvel_z_raw", "77");
  ASSERT_TRUE(test::waitUntil([&] {
    const std::size_t before = samples_.size();
    EXPECT_EQ(test::allocationsDuring([&] { imu_.tick(); }), 0U);
    return samples_.size() > before;
  }));
}

}  // namespace
}  // namespace slam::iio_imu_test
