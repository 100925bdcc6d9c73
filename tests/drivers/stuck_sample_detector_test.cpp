// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/stuck_sample_detector.hpp"

#include <array>
#include <gtest/gtest.h>
#include <utility>

namespace slam::stuck_sample_detector_test {
namespace {

TEST(StuckSampleDetector, CallsASensorStuckAfterAsManyRepeatsAsAreNoChance) {
  StuckSampleDetector watch(3);
  EXPECT_FALSE(watch.isStuck(7));
  EXPECT_FALSE(watch.isStuck(7));
  EXPECT_FALSE(watch.isStuck(7));
  EXPECT_TRUE(watch.isStuck(7));
  EXPECT_TRUE(watch.isStuck(7));
  EXPECT_FALSE(watch.isStuck(8)) << "it lives again";
  EXPECT_FALSE(watch.isStuck(8));
}

TEST(StuckSampleDetector, NeverCallsOneStuckThatAlternates) {
  StuckSampleDetector watch(2);
  for (std::uint64_t i = 0; i < 20; ++i) EXPECT_FALSE(watch.isStuck(i % 2));
}

TEST(DigestOf, DiffersForEachBitAndForTheOrder) {
  std::array<std::uint8_t, 21> data{};
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(7 * i);
  const std::uint64_t digest = digestOf(data);
  EXPECT_EQ(digestOf(data), digest);
  for (std::size_t bit = 0; bit < 8 * data.size(); ++bit) {
    data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_NE(digestOf(data), digest) << bit;
    data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
  }
  std::swap(data[0], data[9]);
  EXPECT_NE(digestOf(data), digest);
}

}  // namespace
}  // namespace slam::stuck_sample_detector_test
