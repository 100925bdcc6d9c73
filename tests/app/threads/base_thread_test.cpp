// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/base_thread.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <utility>
#include <vector>

#include "drivers/board/handsfree_fixture.hpp"
#include "runtime/clock.hpp"
#include "support/wait_until.hpp"

namespace slam::base_thread_test {
namespace {

using namespace std::chrono_literals;

class BaseThreadTest : public testing::Test {
 protected:
  BaseThreadTest() {
    config_.base_device.port = board_.path();
    config_.base_device.speed_commands = true;
    config_.runtime.realtime = false;
    thread_ = std::make_unique<BaseThread>(config_, channels_->base());
  }
  template <typename Condition>
  [[nodiscard]] bool serveUntil(Condition&& condition) {
    return test::waitUntil([&] {
      board_.serve();
      return condition();
    });
  }
  void drive(Duration ago) { channels_->commands.drives.tryPush({{.vx = 0.5}, monotonicNow() - ago}); }

  test::FakeBoard board_;
  Config config_;
  std::unique_ptr<Channels> channels_ = std::make_unique<Channels>();
  std::unique_ptr<BaseThread> thread_;
};

TEST_F(BaseThreadTest, DoesNotObeyWhatWaitedInTheQueueUntilItWasOld) {
  for (int i = 0; i < 8; ++i) drive(501ms);
  thread_->worker().start();
  ASSERT_TRUE(serveUntil([&] { return !board_.drives.empty() && thread_->wheelStatus()->samples > 5; }));
  for (const auto& drive : board_.drives) EXPECT_EQ(drive.speed.x, 0.0F);
}

TEST_F(BaseThreadTest, StopsTheRobotAtItsEnd) {
  thread_->worker().start();
  ASSERT_TRUE(serveUntil([&] {
    drive(0ms);
    return board_.speed.x == 0.5F;
  }));
  thread_->stop();
  board_.serve();
  EXPECT_EQ(board_.speed.x, 0.0F);
}

TEST_F(BaseThreadTest, DrivesInTheDirectionThatIsCommanded) {
  thread_->worker().start();
  ASSERT_TRUE(serveUntil([&] {
    channels_->commands.drives.tryPush({{.vx = 0.25, .vy = -0.125, .omega = 0.75}, monotonicNow()});
    return board_.speed.x == 0.25F;
  }));
  EXPECT_EQ(board_.speed.y, -0.125F);
  EXPECT_EQ(board_.speed.z, 0.75F);
}

TEST_F(BaseThreadTest, HandsWheelsAndImuToTheEstimatorAndToTheBus) {
  thread_->worker().start();
  ASSERT_TRUE(serveUntil([&] { return thread_->wheelStatus()->samples > 5 && thread_->imuStatus()->samples > 5; }));
  thread_->stop();
  std::vector<WheelReading> wheels, wheels_out;
  channels_->samples.wheels.drain([&](const WheelReading& reading) { wheels.push_back(reading); });
  channels_->raw.wheels.drain([&](const WheelReading& reading) { wheels_out.push_back(reading); });
  ASSERT_EQ(wheels.size(), wheels_out.size());
  ASSERT_GT(wheels.size(), 5U);
  EXPECT_EQ(wheels.back().count, 2);
  EXPECT_EQ(wheels.back().angles, wheels_out.back().angles);
  EXPECT_GT(wheels.back().sample.T_wheels_base.x, 0.0) << "both wheels count forward";
  EXPECT_GT(wheels.back().sample.T_wheels_base.theta, 0.0) << "and the right one more";
  std::vector<ImuSample> imu, imu_out;
  channels_->samples.imu.drain([&](const ImuSample& sample) { imu.push_back(sample); });
  channels_->raw.imu.drain([&](const ImuSample& sample) { imu_out.push_back(sample); });
  ASSERT_EQ(imu.size(), imu_out.size());
  ASSERT_GT(imu.size(), 5U);
  EXPECT_EQ(imu.back().gyro, imu_out.back().gyro);
  EXPECT_NEAR(imu.back().gyro.z(), 0.3, 1e-6);
  EXPECT_NEAR(static_cast<double>(thread_->battery()), 11.5, 1e-6);
}

TEST(BaseThreadOnCan, ShowsTheCountersOfTheLink) {
  Config config;
  config.runtime.realtime = false;
  config.base_device.driver = BaseDriver::kCan;
  config.imu_device.driver = ImuDriver::kNone;
  config.can.interface = "none0";
  const auto channels = std::make_unique<Channels>();
  BaseThread thread(config, channels->base());
  ASSERT_TRUE(thread.usesCan());
  thread.worker().start();
  CanLinkCounters counters;
  EXPECT_TRUE(test::waitUntil([&] { return channels->can_counters.load(counters); }));
}

TEST(BaseRates, AreThoseAtWhichValuesAreNew) {
  const auto ratesOf = [](BaseDriver base, ImuDriver imu, double mileage_rate, double imu_rate) {
    Config config;
    config.runtime.realtime = false;
    config.base_device.port = config.imu_device.port = "/dev/none";
    config.base_device.driver = base;
    config.imu_device.driver = imu;
    config.base_device.mileage_rate = mileage_rate;
    config.base_device.imu_rate = imu_rate;
    Channels channels;
    BaseThread thread(config, channels.base());
    return std::pair(thread.wheelRate(), thread.imuRate());
  };
  EXPECT_EQ(ratesOf(BaseDriver::kHandsfree, ImuDriver::kHandsfree, 100.0, 100.0), std::pair(20.0, 50.0))
      << "what the board renews";
  EXPECT_EQ(ratesOf(BaseDriver::kHandsfree, ImuDriver::kHandsfree, 15.0, 40.0), std::pair(15.0, 40.0))
      << "what it is asked for";
  EXPECT_EQ(ratesOf(BaseDriver::kCan, ImuDriver::kCan, 15.0, 40.0), std::pair(100.0, 100.0));
  EXPECT_EQ(ratesOf(BaseDriver::kKobuki, ImuDriver::kBase, 15.0, 40.0), std::pair(50.0, 50.0));
  EXPECT_EQ(ratesOf(BaseDriver::kHandsfree, ImuDriver::kHfi, 100.0, 40.0).second, 0.0) << "nobody knows";
}

}  // namespace
}  // namespace slam::base_thread_test
