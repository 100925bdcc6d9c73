// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/device_time.hpp"

#include <gtest/gtest.h>

namespace slam::device_time_test {
namespace {

using namespace std::chrono_literals;

constexpr Timestamp kStart{100s};

TEST(DeviceTime, GoesOnWhereItsCounterWraps) {
  DeviceTime time(1us);
  std::uint32_t ticks = UINT32_MAX - 100'000;
  for (int i = 0; i < 100; ++i, ticks += 10'000) {
    const Duration late = i % 7 == 0 ? Duration(0) : Duration(2ms);  // on its way
    const auto [stamp, restarted] = time.add(ticks, kStart + i * 10ms + late);
    EXPECT_FALSE(restarted) << i;
    EXPECT_LE(std::chrono::abs(stamp - (kStart + i * 10ms)), 20us) << i;
  }
}

TEST(DeviceTime, BeginsAnewBehindAResetAndBehindALongSilence) {
  DeviceTime time(1us);
  EXPECT_FALSE(time.add(3'000'000'000U, kStart).restarted);
  EXPECT_FALSE(time.add(3'000'010'000U, kStart + 10ms).restarted);
  EXPECT_TRUE(time.add(1'000U, kStart + 300ms).restarted) << "it counts from 0";
  EXPECT_EQ(time.add(11'000U, kStart + 310ms).stamp, kStart + 310ms);
  EXPECT_TRUE(time.add(5'000'000U, kStart + 5s).restarted);
  DeviceTime fast(1ms);
  fast.add(500, kStart);
  EXPECT_TRUE(fast.add(400, kStart + 10ms).restarted) << "back by however little";
}

}  // namespace
}  // namespace slam::device_time_test
