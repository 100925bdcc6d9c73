// SPDX-License-Identifier: BSD-3-Clause
#include "bus/refusal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bus/channels.hpp"
#include "bus/encoding.hpp"
#include "bus/received.hpp"

namespace slam::refusal_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
constexpr std::int64_t kUtime = 1'700'000'000'123'456;

scan_t someScan(int beams) {
  scan_t message{};
  message.utime = kUtime;
  message.range_min = 0.15F;
  message.range_max = 12.0F;
  message.nbeams = beams;
  for (int i = 0; i < beams; ++i) {
    message.ranges.push_back(2.0F);
    message.bearings.push_back(6.28F * static_cast<float>(i) / static_cast<float>(beams) - 3.14F);
    message.time_offsets.push_back(0.0F);
    message.intensities.push_back(0.0F);
  }
  return message;
}

template <typename Message>
Refusal refusalOfWire(const Message& message) {
  return Received<Message>(test::encoded(message)).refusal;
}

TEST(Received, ReportsWhyAMessageIsNoMeasurement) {
  EXPECT_EQ(refusalOfWire(someScan(100)), Refusal::kNone);
  EXPECT_EQ(Received<scan_t>(test::encoded(imu_t{})).refusal, Refusal::kType);
  EXPECT_EQ(Received<scan_t>({}).refusal, Refusal::kType);
  auto cut = test::encoded(someScan(100));
  cut.pop_back();
  EXPECT_EQ(Received<scan_t>(cut).refusal, Refusal::kSize);
  for (const auto& [spoil, refusal] : std::initializer_list<std::pair<void (*)(scan_t&), Refusal>>{
           {[](scan_t& m) { m.utime = 0; }, Refusal::kStamp},
           {[](scan_t& m) { m.range_max = 0.1F; }, Refusal::kLimits},
           {[](scan_t& m) { m.range_max = -1.0F; }, Refusal::kLimits}}) {
    scan_t message = someScan(10);
    spoil(message);
    EXPECT_EQ(refusalOfWire(message), refusal);
  }
  wheels_t wheels{};
  wheels.utime = kUtime;
  wheels.theta = NAN;
  EXPECT_EQ(refusalOfWire(wheels), Refusal::kValues);
  imu_t imu{};
  imu.utime = kUtime;
  imu.gyro[2] = INFINITY;
  EXPECT_EQ(refusalOfWire(imu), Refusal::kValues);
}

TEST(Received, TakesARangeMaxOfZeroForNotGiven) {
  scan_t message = someScan(10);
  message.range_max = 0.0F;
  const Received<scan_t> received(test::encoded(message));
  ASSERT_TRUE(received);
  for (const Beam& beam : received.sample->beams()) EXPECT_TRUE(received.sample->isReturn(beam));
}

TEST(Received, ThinsTooManyBeamsEvenlyOverTheTurn) {
  for (const int beams : {4081, 4200, 9000, 65536}) {
    const Received<scan_t> received(test::encoded(someScan(beams)));
    ASSERT_TRUE(received) << beams;
    EXPECT_EQ(received.sample->size, LaserScan::kCapacity);
    EXPECT_EQ(thinnedBeams(*received.message), beams - LaserScan::kCapacity);
    const auto used = received.sample->beams();
    const float step = 6.28F / static_cast<float>(LaserScan::kCapacity);
    for (std::size_t i = 1; i < used.size(); ++i) {
      ASSERT_GT(used[i].bearing, used[i - 1].bearing);
      ASSERT_LT(used[i].bearing - used[i - 1].bearing, 2.1F * step);
    }
    EXPECT_LT(used.front().bearing, -3.13F);
    EXPECT_GT(used.back().bearing, 3.13F);
  }
  EXPECT_EQ(thinnedBeams(someScan(LaserScan::kCapacity)), 0);
}

TEST(RefusalNote, NamesTheReasonOnceManyAreRefused) {
  RefusalNote note;
  note.refused(Refusal::kSize);
  EXPECT_EQ(note.noted(), Refusal::kNone) << "one that was damaged on its way";
  for (int i = 0; i < 5; ++i) note.refused(Refusal::kLimits);
  EXPECT_EQ(note.noted(), Refusal::kLimits);
  EXPECT_EQ(note.count(Refusal::kLimits), 5);
  EXPECT_EQ(note.count(Refusal::kSize), 1);
  note.taken();
  EXPECT_NE(note.noted(), Refusal::kNone) << "most are refused";
  for (int i = 0; i < 20; ++i) note.taken();
  EXPECT_EQ(note.noted(), Refusal::kNone);
}

TEST(RefusalNote, StaysTheSameWhileEachThirdMessageIsRefused) {
  RefusalNote note;
  for (int i = 0; i < 30; ++i) i % 3 == 0 ? note.refused(Refusal::kValues) : note.taken();
  for (int i = 0; i < 300; ++i) {
    i % 3 == 0 ? note.refused(Refusal::kValues) : note.taken();
    ASSERT_EQ(note.noted(), Refusal::kValues);
  }
}

TEST(RefusalNote, NamesNoneForOneInTen) {
  RefusalNote note;
  for (int i = 0; i < 1000; ++i) {
    i % 10 == 0 ? note.refused(Refusal::kValues) : note.taken();
    ASSERT_EQ(note.noted(), Refusal::kNone);
  }
}

TEST(RefusedMessages, OfALogAreCountedByReason) {
  RefusedMessages refused(channel::kScan);
  refused.count(Refusal::kNone);
  EXPECT_EQ(refused.words(), "");
  for (int i = 0; i < 3; ++i) refused.count(Refusal::kLimits);
  refused.count(Refusal::kType);
  EXPECT_THAT(refused.words(), StartsWith("4 of 5 SLAM_SCAN are rejected; 1: the messages are of another type"));
  EXPECT_THAT(refused.words(), HasSubstr("; 3: range_min or range_max"));
}

TEST(Refusal, HasANameACauseAndAFixForEachReason) {
  for (std::size_t i = 1; i < kRefusals; ++i) {
    const auto refusal = static_cast<Refusal>(i);
    EXPECT_STRNE(nameOf(refusal), "");
    EXPECT_THAT(problemOf(refusal, channel::kWheels).words(),
                testing::MatchesRegex("SLAM_WHEELS is rejected: .+; slamd goes on without such messages; fix: .+"));
  }
}

}  // namespace
}  // namespace slam::refusal_test
