// SPDX-License-Identifier: BSD-3-Clause
#include "timing/device_clock.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace slam::device_clock_test {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPeriod = 33ms;
constexpr Timestamp kStart{1000s};
constexpr Duration kLeastDelay = 15ms;  // [s] of transfer: nobody can see it from here

/// Feeds a device whose clock runs off by `drift` with delays of up to tens of milliseconds.
/// @return [s] errors of the stamps, less the least delay, sorted
std::vector<double> errors(double drift, int count) {
  DeviceClock clock;
  std::mt19937 random(4);
  std::exponential_distribution<double> delay(1.0 / 0.004);
  std::vector<double> errors;
  for (int i = 0; i < count; ++i) {
    const Duration real = i * kPeriod;
    const auto device = Duration(static_cast<std::int64_t>(static_cast<double>(real.count()) * (1.0 + drift)));
    const Timestamp arrival = kStart + real + kLeastDelay + fromSeconds(std::min(0.05, delay(random)));
    const Timestamp stamp = clock.stamp(device, arrival);
    EXPECT_LE(stamp, arrival);
    if (i > 200) errors.push_back(std::abs(toSeconds(stamp - (kStart + real + kLeastDelay))));
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

TEST(DeviceClock, IsRightToAMillisecondUnderJitteredArrival) {
  for (const double drift : {0.0, 50e-6, -50e-6}) {
    const auto sorted = errors(drift, 5000);
    EXPECT_LT(sorted[sorted.size() * 95 / 100], 0.001) << drift;
  }
}

TEST(DeviceClock, BeginsAnewWhenTheDeviceDoes) {
  DeviceClock clock;
  clock.stamp(100s, kStart);
  EXPECT_EQ(clock.stamp(0s, kStart + 1s), kStart + 1s) << "plugged in again";
  clock.stamp(1s, kStart + 2s);
  EXPECT_EQ(clock.stamp(2s, kStart + 60s), kStart + 60s) << "it set its clock back by most of a minute";
}

TEST(DeviceClock, LeavesOutOneLateSample) {
  DeviceClock clock;
  clock.stamp(0s, kStart);
  EXPECT_LT(clock.stamp(33ms, kStart + 300ms) - (kStart + 33ms), 1ms);
}

}  // namespace
}  // namespace slam::device_clock_test
