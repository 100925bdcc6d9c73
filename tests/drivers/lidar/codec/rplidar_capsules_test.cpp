// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/rplidar_capsules.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

namespace slam::rplidar::rplidar_capsules_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::ElementsAre;

constexpr int kTurn = 360 * 64;  // [deg/64]

template <std::size_t N>
Bytes bytesOf(const std::array<std::uint8_t, N>& array) {
  return {array.begin(), array.end()};
}

/// Its own arithmetic, from the formula of the protocol.
double offsetDegrees(std::uint32_t distance_q2) {
  if (distance_q2 < 200) return 7.5;
  const double k = std::floor(98361.0 / distance_q2);
  const double q16 = std::floor(8.0 * std::numbers::pi / 180.0 * 65536.0) - 64.0 * k - k * k * k / 98304.0;
  return q16 / 65536.0 * 180.0 / std::numbers::pi;
}

std::array<int, kUltraSamples> distancesLike(double slope) {
  std::array<int, kUltraSamples> distances;
  for (std::size_t k = 0; k < distances.size(); ++k)
    distances[k] = 300 + static_cast<int>(slope * static_cast<double>(k));
  return distances;
}

UltraCapsule capsuleAt(double degrees, const std::array<int, kUltraSamples>& distances, int next_first) {
  return {.start_angle_q6 = static_cast<std::uint16_t>(degrees * 64.0),
          .cabins = encodeUltraCabins(distances, next_first)};
}

// ---- Ultra capsules

TEST(UltraScale, ChangesItsStepAtTheLimitsOfTheProtocol) {
  const auto expectScale = [](std::uint16_t major, int mm, int level) {
    EXPECT_EQ(decodeMajor(major).mm, mm) << major;
    EXPECT_EQ(decodeMajor(major).level, level) << major;
  };
  expectScale(0, 0, 0);
  expectScale(511, 511, 0);
  expectScale(512, 512, 1);
  expectScale(1279, 2046, 1);
  expectScale(1280, 2048, 2);
  expectScale(1791, 4092, 2);
  expectScale(1792, 4096, 3);
  expectScale(3327, 16376, 3);
  expectScale(3328, 16384, 4);
  expectScale(4095, 28656, 4);
}

TEST(UltraScale, EveryValueSurvivesARoundTrip) {
  for (std::uint16_t major = 0; major < 4096; ++major) EXPECT_EQ(encodeMajor(decodeMajor(major).mm), major);
  EXPECT_EQ(encodeMajor(100000), 4095);
}

TEST(UltraCapsule, LaysItsBitsOutAsTheProtocolDoes) {
  UltraCapsule capsule{.start_angle_q6 = 10 * 64, .start = true};
  for (auto& cabin : capsule.cabins) cabin = {0, 0, 0};
  capsule.cabins[0] = {0xABC, -2, 5};
  capsule.cabins[1] = {0x001, 511, kNoPrediction};
  const Bytes bytes = bytesOf(encodeUltraCapsule(capsule));
  // 0xABC | 0x3FE << 12 | 5 << 22 = 0x017FEABC; 1 | 0x1FF << 12 | 0x200 << 22 = 0x801FF001
  EXPECT_THAT(Bytes(bytes.begin() + 2, bytes.begin() + 12),
              ElementsAre(0x80, 0x82, 0xBC, 0xEA, 0x7F, 0x01, 0x01, 0xF0, 0x1F, 0x80));
  std::uint8_t sum = 0;
  for (std::size_t i = 2; i < bytes.size(); ++i) sum ^= bytes[i];
  EXPECT_EQ(bytes[0], 0xA0 | (sum & 0x0F));
  EXPECT_EQ(bytes[1], 0x50 | sum >> 4);
  const auto back = parseUltraCapsule(bytes);
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->start);
  EXPECT_EQ(back->start_angle_q6, 640);
  EXPECT_EQ(back->cabins[0].major, 0xABC);
  EXPECT_EQ(back->cabins[0].predict1, -2);
  EXPECT_EQ(back->cabins[0].predict2, 5);
  EXPECT_EQ(back->cabins[1].predict1, 511);
  EXPECT_EQ(back->cabins[1].predict2, -512);
}

TEST(UltraCapsule, WithAnyOneBitFlippedIsRefused) {
  Bytes bytes = bytesOf(encodeUltraCapsule(capsuleAt(33, distancesLike(7), 990)));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(parseUltraCapsule(bytes)) << "bit " << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
  }
  bytes.pop_back();
  EXPECT_FALSE(parseUltraCapsule(bytes));
}

TEST(UltraCapsule, DistancesSurviveARoundTripToTheStepOfTheirScale) {
  for (const double slope : {0.0, 1.0, 10.0, 60.0, 150.0}) {
    const auto distances = distancesLike(slope);
    const int next_first = distances.back() + static_cast<int>(slope);
    const auto nodes = decodeUltra(capsuleAt(10, distances, next_first), capsuleAt(34, distancesLike(0), 300));
    for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
      const int from = distances[std::min(k + 2, distances.size() - 1)];  // the first one of the next cabin, at most
      const int step = from < 500 ? 0 : from < 2000 ? 1 : from < 4000 ? 2 : 4;
      EXPECT_NEAR(nodes[k].distance_q2 / 4.0, distances[k], step) << slope << ' ' << k;
    }
  }
}

TEST(UltraCapsule, TheLastSampleCountsFromTheNextCapsulesFirstCabin) {
  UltraCapsule capsule{}, next{.start_angle_q6 = 24 * 64};
  capsule.cabins[31] = {700, 4, 3};
  next.cabins[0].major = 1400;  // 2048 + 120 * 4 mm, level 2
  const auto nodes = decodeUltra(capsule, next);
  EXPECT_EQ(nodes[93].distance_q2, 4U * (512 + 188 * 2));
  EXPECT_EQ(nodes[94].distance_q2, 4U * (512 + 188 * 2 + 4 * 2));
  EXPECT_EQ(nodes[95].distance_q2, 4U * (2528 + 3 * 4));
}

TEST(UltraCapsule, WithoutAFirstEchoTheSecondCountsFromTheThird) {
  UltraCapsule capsule{}, next{.start_angle_q6 = 24 * 64};
  capsule.cabins[0] = {0, -3, 2};
  capsule.cabins[1] = {1300, kNoPrediction, 511};  // 2048 + 20 * 4 mm, level 2
  const auto nodes = decodeUltra(capsule, next);
  EXPECT_EQ(nodes[0].distance_q2, 0U);
  EXPECT_EQ(nodes[1].distance_q2, 4U * (2128 - 3 * 4));
  EXPECT_EQ(nodes[2].distance_q2, 4U * (2128 + 2 * 4));
  EXPECT_EQ(nodes[3].distance_q2, 4U * 2128);
  EXPECT_EQ(nodes[4].distance_q2, 0U) << "-512 says no echo";
  EXPECT_EQ(nodes[5].distance_q2, 0U) << "so does +511";
  EXPECT_EQ(nodes[0].quality, 0);
  EXPECT_GT(nodes[1].quality, 0);
}

TEST(UltraCapsule, ADifferenceBeyondTenBitsIsSentAsNoEcho) {
  auto distances = distancesLike(0);  // 300 mm, level 0
  distances[1] = 2000;
  const auto nodes = decodeUltra(capsuleAt(0, distances, 300), capsuleAt(24, distancesLike(0), 300));
  EXPECT_EQ(nodes[1].distance_q2, 0U);
  EXPECT_EQ(nodes[2].distance_q2, 1200U);
}

TEST(UltraCapsule, AnglesAreCorrectedByDistance) {
  for (const std::uint32_t q2 : {200U, 400U, 600U, 1000U, 4000U, 16000U, 48000U}) {
    EXPECT_NEAR(ultraAngleOffsetQ16(q2) / 65536.0, offsetDegrees(q2), 1e-3) << q2;
  }
  EXPECT_NEAR(ultraAngleOffsetQ16(199) / 65536.0, 7.5, 1e-3);
  EXPECT_NEAR(ultraAngleOffsetQ16(0) / 65536.0, 7.5, 1e-3);

  const auto nodes = decodeUltra(capsuleAt(100, distancesLike(20), 2220), capsuleAt(124, distancesLike(0), 300));
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double raw = 100.0 + 24.0 * static_cast<double>(k) / 96.0;
    EXPECT_NEAR(nodes[k].angle_q6 / 64.0, raw - offsetDegrees(nodes[k].distance_q2), 1.0 / 60.0) << k;
  }
}

TEST(UltraCapsule, StartsATurnAtTheLastSampleBeforeZeroWhateverItsCorrection) {
  const auto nodes = decodeUltra(capsuleAt(350, distancesLike(20), 2220), capsuleAt(14, distancesLike(0), 300));
  for (int k = 0; k < kUltraSamples; ++k) {
    EXPECT_EQ(nodes[static_cast<std::size_t>(k)].start, k == 39) << k;  // 350 + 40 / 4 = 360
  }
}

TEST(UltraCapsule, AnyContentGivesAnglesWithinATurn) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    UltraCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(random() % 0x8000)};
    for (auto& cabin : capsule.cabins) {
      cabin = {static_cast<std::uint16_t>(random() % 4096), static_cast<std::int16_t>(random() % 1024 - 512),
               static_cast<std::int16_t>(random() % 1024 - 512)};
    }
    UltraCapsule next{.start_angle_q6 = static_cast<std::uint16_t>(random() % 0x8000)};
    for (const Node& node : decodeUltra(capsule, next)) {
      ASSERT_LT(node.angle_q6, kTurn);
      ASSERT_LT(node.distance_q2, 4U * 40000U) << "a distance below zero is no echo";
    }
  }
}

// ---- Dense capsules

TEST(DenseCapsule, LaysItsBytesOutAsTheProtocolDoes) {
  DenseCapsule capsule{.start_angle_q6 = 10 * 64, .start = true};
  capsule.distances_mm[0] = 0x1234;
  capsule.distances_mm[39] = 0xFFFE;
  const Bytes bytes = bytesOf(encodeDenseCapsule(capsule));
  ASSERT_EQ(bytes.size(), 84U);
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 6), ElementsAre(0xA5, 0x52, 0x80, 0x82, 0x34, 0x12));
  EXPECT_EQ(bytes[82], 0xFE);
  const auto back = parseDenseCapsule(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->distances_mm, capsule.distances_mm);
  EXPECT_TRUE(back->start);
}

TEST(DenseCapsule, PlacesItsSamplesWithoutCorrection) {
  DenseCapsule capsule{.start_angle_q6 = 350 * 64};
  for (std::size_t k = 0; k < capsule.distances_mm.size(); ++k)
    capsule.distances_mm[k] = static_cast<std::uint16_t>(500 * k);
  const auto nodes = decodeDense(capsule, 10 * 64);
  for (int k = 0; k < kDenseSamples; ++k) {
    const Node& node = nodes[static_cast<std::size_t>(k)];
    EXPECT_EQ(node.angle_q6, (350 * 64 + 32 * k) % kTurn) << k;
    EXPECT_EQ(node.distance_q2, 2000U * static_cast<unsigned>(k)) << k;
    EXPECT_EQ(node.start, k == 19) << k;
    EXPECT_EQ(node.quality > 0, k > 0) << k;
  }
}

TEST(DenseCapsule, BeginsAsComputedFromTheDocument) {
  DenseCapsule capsule{.start_angle_q6 = 10 * 64, .start = true};
  for (std::size_t k = 0; k < capsule.distances_mm.size(); ++k)
    capsule.distances_mm[k] = static_cast<std::uint16_t>(1000 + k);
  const Bytes bytes = bytesOf(encodeDenseCapsule(capsule));
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 10),
              ElementsAre(0xA2, 0x50, 0x80, 0x82, 0xE8, 0x03, 0xE9, 0x03, 0xEA, 0x03));
}

// ---- Ultra-dense capsules. No recorded one is published: these bits are computed from the vendor's driver.

TEST(UltraDenseCapsule, ReadsEachOfItsFourScales) {
  const auto expect = [](std::uint32_t bits, std::uint32_t mm, int quality) {
    const UltraDenseCapsule::Sample sample = decodeUltraDenseSample(bits);
    EXPECT_EQ(sample.distance_q2, 4 * mm) << mm;
    EXPECT_EQ(sample.quality, quality) << mm;
    EXPECT_EQ(encodeUltraDenseSample(sample), bits) << mm;
  };
  expect(0x2F7D0, 1000, 47);
  expect(0x2EFA1, 5046, 46);
  expect(0x2CFA2, 12187, 44);
  expect(0x292C3, 30567, 40);
  expect(0, 0, 0);
}

TEST(UltraDenseCapsule, RoundsADistanceToTheNearestOfItsScale) {
  for (std::uint32_t mm = 0; mm <= 65522; ++mm) {
    const auto sample = decodeUltraDenseSample(encodeUltraDenseSample({4 * mm, 40}));
    const double step = mm <= 2046 ? 2.0 : mm <= 8187 ? 3.0 : mm <= 24567 ? 4.0 : 5.0;  // [mm]
    ASSERT_LE(std::abs(sample.distance_q2 / 4.0 - mm), step / 2.0) << mm;
    ASSERT_EQ(sample.quality, 40) << mm;
  }
}

TEST(UltraDenseCapsule, LaysItsBytesOutAsTheProtocolDoes) {
  UltraDenseCapsule capsule{.start_angle_q6 = 350 * 64, .start = true};
  capsule.samples[0] = {4 * 1000, 47};
  capsule.samples[1] = {4 * 5046, 46};
  Bytes bytes = bytesOf(encodeUltraDenseCapsule(capsule));
  ASSERT_EQ(bytes.size(), 170U);
  EXPECT_THAT(Bytes(bytes.begin() + 8, bytes.begin() + 15), ElementsAre(0x80, 0xD7, 0xD0, 0xF7, 0xA1, 0xEF, 0x22));
  const auto back = parseUltraDenseCapsule(bytes);
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->start);
  const auto nodes = decodeUltraDense(*back, 6 * 64);
  EXPECT_EQ(nodes[1].angle_q6, 350 * 64 + 16);
  EXPECT_EQ(nodes[1].distance_q2, 4U * 5046);
  EXPECT_EQ(nodes[1].quality, 46);
  EXPECT_EQ(nodes[2].distance_q2, 0U);
  EXPECT_EQ(nodes[2].quality, 0);
  EXPECT_TRUE(nodes[39].start);
  bytes[4] ^= 1;  // of its time stamp, which the checksum covers
  EXPECT_FALSE(parseUltraDenseCapsule(bytes));
}

TEST(CapsuleSpan, NeitherMissesNorDoublesATurnBetweenUnevenCapsules) {
  std::mt19937 random(4);
  for (const int count : {kExpressSamples, kDenseSamples, kUltraSamples}) {
    int turned = 0, starts = 0;
    std::uint16_t angle = 0;
    for (int i = 0; i < 3000; ++i) {
      const int width = 1000 + static_cast<int>(random() % 1000);
      const auto next = static_cast<std::uint16_t>((angle + width) % kTurn);
      const CapsuleSpan span(angle, next, count);
      for (int k = 0; k < count; ++k) starts += span.at(k).start;
      turned += width;
      angle = next;
    }
    EXPECT_EQ(starts, turned / kTurn) << count;
  }
}

}  // namespace
}  // namespace slam::rplidar::rplidar_capsules_test
