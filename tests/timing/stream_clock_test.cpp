// SPDX-License-Identifier: BSD-3-Clause
#include "timing/stream_clock.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <ostream>
#include <random>
#include <vector>

namespace slam::stream_clock_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{1000s};

struct Stream {
  double period;    // [s]
  double delay;     // [s] mean, of exponential delays
  double tick = 0;  // [s] arrivals are seen at its multiples only; 0: at once
  double loss = 0;  // [1] share of samples that are lost, and known to be
  friend std::ostream& operator<<(std::ostream& out, const Stream& s) {
    return out << s.period << " s, delay " << s.delay << " s, tick " << s.tick << " s, loss " << s.loss;
  }
};

/// @return [s] errors of the stamps, less the least delay, sorted
std::vector<double> errors(const Stream& stream, int count) {
  StreamClock clock;
  std::mt19937 random(5);
  std::exponential_distribution<double> delay(1.0 / stream.delay);
  std::bernoulli_distribution lose(stream.loss);
  std::vector<double> errors;
  double arrived = 0.0;
  Timestamp last{};
  bool lost = false;
  for (int i = 0; i < count; ++i) {
    const double taken = i * stream.period;
    arrived = std::max(arrived, taken + std::min(0.05, delay(random)));
    if (stream.tick > 0.0) arrived = std::ceil(arrived / stream.tick) * stream.tick;
    if (lose(random)) {
      lost = true;
      continue;
    }
    const Timestamp stamp = clock.stamp(kStart + fromSeconds(arrived), lost);
    lost = false;
    EXPECT_GE(stamp, last);
    EXPECT_LE(stamp, kStart + fromSeconds(arrived));
    last = stamp;
    if (i > 1000) errors.push_back(std::abs(toSeconds(stamp - (kStart + fromSeconds(taken)))));
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

class JitteredStream : public testing::TestWithParam<Stream> {};

TEST_P(JitteredStream, IsStampedRightToAMillisecond) {
  const auto sorted = errors(GetParam(), 20000);
  const double p95 = sorted[sorted.size() * 95 / 100];
  EXPECT_LT(p95, 0.001) << GetParam();
  RecordProperty("p95_us", static_cast<int>(1e6 * p95));
  RecordProperty("worst_us", static_cast<int>(1e6 * sorted.back()));
}

INSTANTIATE_TEST_SUITE_P(Of, JitteredStream,
                         testing::Values(Stream{0.005, 0.001}, Stream{0.005, 0.004}, Stream{0.010, 0.004},
                                         Stream{1.0 / 300.0, 0.002}, Stream{0.010013, 0.0005, 1.0 / 211.0},
                                         Stream{0.005, 0.0005, 1.0 / 211.0}, Stream{0.0458, 0.001},
                                         Stream{0.005, 0.001, 0, 0.01}));

TEST(StreamClock, StampsWithTheArrivalUntilItHasTheRate) {
  StreamClock clock;
  for (int i = 0; i < 60; ++i) EXPECT_EQ(clock.stamp(kStart + i * 10ms), kStart + i * 10ms);
  EXPECT_FALSE(clock.learned());
}

TEST(StreamClock, BeginsAnewBehindAGap) {
  StreamClock clock;
  for (int i = 0; i < 200; ++i) clock.stamp(kStart + i * 10ms);
  EXPECT_TRUE(clock.learned());
  EXPECT_EQ(clock.stamp(kStart + 60s), kStart + 60s);
}

TEST(StreamClock, DistinguishesABurstApart) {
  StreamClock clock;
  for (int i = 0; i < 500; ++i) clock.stamp(kStart + i * 10ms);
  for (int i = 500; i < 504; ++i) {  // four samples that waited for a thread that was late
    EXPECT_LT(std::abs(toSeconds(clock.stamp(kStart + 5035ms) - (kStart + i * 10ms))), 1e-4);
  }
}

TEST(StreamClock, IsRightAgainBehindALossThatItMiscounts) {
  StreamClock clock;
  constexpr Duration kDelays[] = {0ms, 8ms, 9ms, 8ms};  // most samples are late, and those that are not tell the time
  int sample = 0;
  const auto next = [&](bool lost) { return clock.stamp(kStart + sample * 10ms + kDelays[sample % 4], lost); };
  for (; sample < 400; ++sample) next(false);
  sample = 404;  // four are lost, and this one came at once: it seems to be three
  next(true);
  for (++sample; sample < 440; ++sample)
    EXPECT_LT(std::abs(toSeconds(next(false) - (kStart + sample * 10ms))), 0.001) << sample;
}

TEST(StreamClock, CountsTheSamplesThatAreLostIntoItsRate) {
  StreamClock clock;
  for (int i = 0; i < 3000; ++i) {
    const int of_fifty = i % 50;
    if (i > 200 && of_fifty == 49) continue;
    const bool held_up = i > 200 && of_fifty >= 25 && of_fifty<45, lost = i> 250 && of_fifty == 0;
    const Timestamp taken = kStart + i * 10ms, stamp = clock.stamp(taken + (held_up ? 4ms : 0ms), lost);
    EXPECT_LT(i > 1000 ? std::abs(toSeconds(stamp - taken)) : 0.0, 0.001) << i;
  }
}

}  // namespace
}  // namespace slam::stream_clock_test
