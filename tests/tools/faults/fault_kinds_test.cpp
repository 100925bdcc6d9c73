// SPDX-License-Identifier: BSD-3-Clause
#include "tools/faults/fault_kinds.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace slam::fault_kinds_test {
namespace {

struct Device {
  bool silent = false;
  int lost = 0;
  double factor = 1.0;
  Duration delay{0};
};
constexpr FaultKind<Device> kKinds[] = {
    {"silent", &Device::silent},
    {"lose", &Device::lost, 1.0, 9.0},
    {"wrong", &Device::factor, -2.0, 2.0},
    {"delay", &Device::delay, 0.0, 500.0},
    {"swap", [](Device& device, double value) { return device.factor = -device.factor, value == 1.0; }},
};

TEST(FaultKinds, PutAValueIntoItsField) {
  Device device;
  EXPECT_TRUE(injectFault(kKinds, device, "silent", 1.0));
  EXPECT_TRUE(device.silent);
  EXPECT_TRUE(injectFault(kKinds, device, "lose", 9.0));
  EXPECT_EQ(device.lost, 9);
  EXPECT_TRUE(injectFault(kKinds, device, "wrong", 0.5));
  EXPECT_EQ(device.factor, 0.5);
  EXPECT_TRUE(injectFault(kKinds, device, "delay", 250.5));
  EXPECT_EQ(device.delay, std::chrono::microseconds(250'500));
  EXPECT_TRUE(injectFault(kKinds, device, "swap", 1.0));
  EXPECT_EQ(device.factor, -0.5);
  EXPECT_FALSE(injectFault(kKinds, device, "swap", 0.0)) << "the function refuses it";
}

TEST(FaultKinds, RefuseWhatIsNoKindAndNoValueOfIt) {
  Device device;
  EXPECT_FALSE(injectFault(kKinds, device, "sulk", 1.0));
  EXPECT_FALSE(injectFault(kKinds, device, "", 1.0));
  for (const double value : {0.5, 2.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(injectFault(kKinds, device, "silent", value)) << value;
  }
  for (const double value : {0.0, 1.5, 10.0}) EXPECT_FALSE(injectFault(kKinds, device, "lose", value)) << value;
  EXPECT_FALSE(injectFault(kKinds, device, "wrong", std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(injectFault(kKinds, device, "delay", 501.0));
  EXPECT_FALSE(device.silent);
  EXPECT_EQ(device.lost, 0);
  EXPECT_EQ(device.factor, 1.0);
}

}  // namespace
}  // namespace slam::fault_kinds_test
