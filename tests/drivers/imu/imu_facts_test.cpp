// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/imu_facts.hpp"

#include <gtest/gtest.h>
#include <set>

#include "tools/sim/imu/emulated_imu.hpp"

namespace slam::imu_facts_test {
namespace {

TEST(ImuFacts, AreOneRowForEachDriverThatIsSimulated) {
  std::set<std::string> drivers;
  for (const ImuFacts& facts : imuTable()) {
    EXPECT_TRUE(drivers.insert(facts.driver).second);
    EXPECT_EQ(findImu(facts.driver), &facts);
    EXPECT_GE(facts.baudCount(), 1U);
    EXPECT_NE(facts.make(), nullptr);
    EXPECT_NE(facts.line_device, LineDevice::kUnknown);
  }
  const auto names = sim::imuNames();
  EXPECT_EQ(drivers, std::set<std::string>(names.begin(), names.end()));
  EXPECT_EQ(findImu("can"), nullptr) << "is no serial one";
}

}  // namespace
}  // namespace slam::imu_facts_test
