// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/latency_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <thread>
#include <vector>

#include "support/allocations.hpp"

namespace slam::latency_histogram_test {
namespace {

constexpr double kWidth = 0.09;  // of a bucket, relative

TEST(LatencyHistogram, IsEmptyAtFirst) {
  const auto summary = LatencyHistogram{}.summary();
  EXPECT_EQ(summary.count, 0);
  EXPECT_EQ(summary.p50_us, 0.0);
  EXPECT_EQ(summary.p99_us, 0.0);
  EXPECT_EQ(summary.max_us, 0.0);
}

class ConstantLatency : public testing::TestWithParam<double> {};

TEST_P(ConstantLatency, IsFoundWithinABucket) {
  LatencyHistogram histogram;
  for (int i = 0; i < 100; ++i) histogram.add(fromSeconds(GetParam() * 1e-6));
  const auto summary = histogram.summary();
  EXPECT_EQ(summary.count, 100);
  EXPECT_NEAR(summary.p50_us, GetParam(), kWidth * GetParam());
  EXPECT_NEAR(summary.p99_us, GetParam(), kWidth * GetParam());
  EXPECT_NEAR(summary.max_us, GetParam(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Microseconds, ConstantLatency,
                         testing::Values(0.2, 1.0, 7.77, 100.0, 1234.5, 20e3, 1e6, 33e6, 90e6));

TEST(LatencyHistogram, QuantilesOfASpreadAreWithinABucket) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> exponent(-0.5, 6.0);  // 0.3 us to 1 s
  LatencyHistogram histogram;
  std::vector<double> all;
  for (int i = 0; i < 20'000; ++i) {
    const Duration duration = fromSeconds(std::pow(10.0, exponent(random)) * 1e-6);
    histogram.add(duration);
    all.push_back(toSeconds(duration) * 1e6);
  }
  std::sort(all.begin(), all.end());
  const auto summary = histogram.summary();
  EXPECT_NEAR(summary.p50_us, all[10'000], kWidth * all[10'000]);
  EXPECT_NEAR(summary.p99_us, all[19'800], kWidth * all[19'800]);
  EXPECT_NEAR(summary.max_us, all.back(), 1e-3);
}

TEST(LatencyHistogram, CountsDurationsOutsideItsRange) {
  LatencyHistogram histogram;
  histogram.add(Duration(0));
  histogram.add(Duration(-5));
  histogram.add(std::chrono::hours(1));
  const auto summary = histogram.summary();
  EXPECT_EQ(summary.count, 3);
  EXPECT_NEAR(summary.max_us, 3600e6, 1.0);
  EXPECT_LT(summary.p50_us, 0.2);
}

TEST(LatencyHistogram, DoesNotAllocate) {
  LatencyHistogram histogram;
  EXPECT_EQ(test::allocationsDuring([&] {
              histogram.add(Duration(1000));
              histogram.summary();
            }),
            0U);
}

TEST(LatencyHistogram, CanBeReadWhileItIsWritten) {
  constexpr std::int64_t kCount = 200'000;
  LatencyHistogram histogram;
  std::thread writer([&] {
    for (std::int64_t i = 0; i < kCount; ++i) histogram.add(std::chrono::microseconds(10 + i % 80));
  });
  std::int64_t last = 0;
  while (last < kCount) {
    const auto summary = histogram.summary();
    EXPECT_GE(summary.count, last);
    EXPECT_LE(summary.p50_us, 90.0 * (1.0 + kWidth));
    last = summary.count;
  }
  writer.join();
  EXPECT_EQ(histogram.summary().count, kCount);
}

TEST(LatencyHistogram, TakesTheMiddleOneOfAFew) {
  LatencyHistogram histogram;
  for (const int microseconds : {1, 100, 10'000}) histogram.add(std::chrono::microseconds(microseconds));
  EXPECT_NEAR(histogram.summary().p50_us, 100.0, kWidth * 100.0);
  EXPECT_NEAR(histogram.summary().p99_us, 10'000.0, kWidth * 10'000.0);
  for (int i = 0; i < 97; ++i) histogram.add(std::chrono::microseconds(1));
  EXPECT_NEAR(histogram.summary().p99_us, 100.0, kWidth * 100.0) << "the 99th of a hundred";
}

TEST(LatencyHistogram, NoPercentileIsAboveTheLongest) {
  for (int i = 0; i < 40; ++i) {  // at all places of a bucket
    LatencyHistogram histogram;
    histogram.add(fromSeconds(1e-3 * (1.0 + 0.01 * i)));
    EXPECT_LE(histogram.summary().p50_us, histogram.summary().max_us);
    EXPECT_LE(histogram.summary().p99_us, histogram.summary().max_us);
  }
}

}  // namespace
}  // namespace slam::latency_histogram_test
