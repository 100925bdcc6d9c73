// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/imu/iio_folder.hpp"
#include "problems/devices.hpp"

namespace slam::iio_device_test {
namespace {

using test::IioFolder;
using testing::HasSubstr;

TEST(IioDevice, IsFoundByItsNameOrItsFolder) {
  const IioFolder folder;
  for (const std::string& wanted : {std::string("mpu6050"), folder.device().string()}) {
    Problem problem;
    const auto device = IioDevice::find(wanted, problem, folder.root());
    ASSERT_TRUE(device) << problem.words();
    EXPECT_EQ(device->name(), "mpu6050");
    EXPECT_TRUE(device->hasAccel());
  }
}

TEST(IioDevice, ReadsRawOffsetAndScale) {
  const IioFolder folder;
  folder.set("in_anglvel_z_raw", "939");
  folder.set("in_anglvel_x_raw", "-100");
  folder.set("in_accel_z_raw", "16399");
  folder.set("in_accel_y_offset", "100");
  Problem problem;
  const auto device = IioDevice::find("mpu6050", problem, folder.root());
  ASSERT_TRUE(device);
  IioDevice::Reading reading;
  ASSERT_TRUE(device->readGyro(reading) && device->readAccel(reading));
  EXPECT_NEAR(reading.gyro.z(), 0.99978, 1e-5) << "[rad/s]";
  EXPECT_NEAR(reading.gyro.x(), -0.1064724, 1e-9);
  EXPECT_NEAR(reading.accel.z(), 9.8066, 1e-4);
  EXPECT_NEAR(reading.accel.y(), 0.0598, 1e-9);
}

TEST(IioDevice, TakesAScaleOfEachAxisBeforeThatOfAll) {
  const IioFolder folder;
  folder.set("in_anglvel_z_scale", "0.5");
  folder.set("in_anglvel_z_raw", "3");
  Problem problem;
  IioDevice::Reading reading;
  ASSERT_TRUE(IioDevice::find("mpu6050", problem, folder.root())->readGyro(reading));
  EXPECT_EQ(reading.gyro.z(), 1.5);
}

TEST(IioDevice, NamesWhatIsMissing) {
  const IioFolder folder;
  Problem problem;
  EXPECT_FALSE(IioDevice::find("bmi160", problem, folder.root()));
  EXPECT_TRUE(problem.is(problem::kIioMissing));
  EXPECT_THAT(problem.words(), HasSubstr("bmi160"));
  EXPECT_FALSE(IioDevice::find("/dev/hfi", problem, folder.root()));
  EXPECT_FALSE(IioDevice::find("", problem, folder.root()));
  EXPECT_FALSE(IioDevice::find("tsl2561", problem, folder.root()));
  EXPECT_TRUE(problem.is(problem::kIioNoGyro)) << problem.words();
  EXPECT_FALSE(IioDevice::find("mpu6050", problem, "/no such folder"));
  folder.remove("in_accel_x_raw");
  const auto bare = IioDevice::find("mpu6050", problem, folder.root());
  ASSERT_TRUE(bare);
  EXPECT_FALSE(bare->hasAccel());
}

TEST(IioDevice, HasTheAccelerationThatIsADeviceOfItsOwn) {
  const IioFolder folder;
  std::filesystem::copy(folder.device(), folder.root() / "iio:device2");
  std::ofstream(folder.root() / "iio:device2" / "name") << "lsm6ds3_accel\n";
  std::ofstream(folder.root() / "iio:device2" / "in_accel_z_raw") << "16399\n";
  folder.set("name", "lsm6ds3_gyro");
  for (const char* axis : {"x", "y", "z"}) folder.remove(std::string("in_accel_") + axis + "_raw");
  Problem problem;
  const auto device = IioDevice::find("lsm6ds3_gyro", problem, folder.root());
  ASSERT_TRUE(device && device->hasAccel()) << problem.words();
  IioDevice::Reading reading;
  ASSERT_TRUE(device->readAccel(reading));
  EXPECT_NEAR(reading.accel.z(), 9.8066, 1e-4);
}

TEST(IioDevice, RefusesWhatIsNoNumber) {
  const IioFolder folder;
  Problem problem;
  const auto device = IioDevice::find("mpu6050", problem, folder.root());
  ASSERT_TRUE(device);
  IioDevice::Reading reading;
  for (const char* text : {"", "12 34", "x", "1e"}) {
    folder.set("in_anglvel_y_raw", text);
    EXPECT_FALSE(device->readGyro(reading)) << text;
  }
  folder.unplug();
  EXPECT_FALSE(device->readGyro(reading));
}

}  // namespace
}  // namespace slam::iio_device_test
