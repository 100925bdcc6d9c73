// SPDX-License-Identifier: BSD-3-Clause
#include "bus/checked_decode.hpp"

#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "bus/encoding.hpp"
#include "core/pseudo_laser.hpp"

namespace slam::checked_decode_test {
namespace {

using test::encoded;
using Bytes = std::vector<std::uint8_t>;

template <typename Message>
Message sample();

template <>
scan_t sample() {
  scan_t message{};
  message.utime = 1;
  message.range_max = 12.0F;
  message.nbeams = 3;
  message.ranges = message.bearings = message.time_offsets = message.intensities = {1.0F, 2.0F, 3.0F};
  return message;
}

template <>
wheels_t sample() {
  wheels_t message{};
  message.utime = 1;
  message.nwheels = 2;
  message.angles = {1.0, 2.0};
  return message;
}

template <>
imu_t sample() {
  imu_t message{};
  message.utime = 1;
  message.gyro[2] = 0.5;
  return message;
}

template <>
command_t sample() {
  command_t message{};
  message.utime = 1;
  message.verb = "save_map";
  message.argument = "/tmp/map";
  return message;
}

template <>
ack_t sample() {
  ack_t message{};
  message.id = 7;
  message.accepted = true;
  message.message = "saved";
  return message;
}

template <>
config_t sample() {
  config_t message{};
  message.host = "robot";
  message.map_id = 3;
  message.configuration = "[log]\nquota = 2000.0\n";
  return message;
}

template <>
health_t sample() {
  health_t message{};
  message.summary = "pose localised";
  message.ndevices = message.nstages = 1;
  message.ncounters = 2;
  message.devices.resize(1);
  message.devices[0].name = "lidar";
  message.devices[0].reason = "no such port";
  message.stages.resize(1);
  message.stages[0].name = "match";
  message.counters.resize(2);
  message.counters[1].name = "scans";
  return message;
}

template <>
problems_t sample() {
  problems_t message{};
  message.nproblems = 2;
  message.problems.resize(2);
  message.problems[0].device = "lidar";
  message.problems[0].id = "port_gone";
  message.problems[1].fix = "check its cable";
  message.problems[1].nnumbers = 1;
  message.problems[1].numbers = {2.5};
  message.problems[1].ntexts = 2;
  message.problems[1].texts = {"left", ""};
  return message;
}

template <>
pose_estimate_t sample() {
  pose_estimate_t message{};
  message.map_id = 3;
  message.x = 1.5;
  message.state = 1;
  return message;
}

template <>
map_edit_t sample() {
  map_edit_t message{};
  message.map_id = 3;
  message.edits = 1;
  message.kind = "zone";
  message.name = "stairs";
  message.npoints = 3;
  message.x = {0.0, 1.0, 1.0};
  message.y = {0.0, 0.0, 1.0};
  return message;
}

template <>
odometry_t sample() {
  odometry_t message{};
  message.x = 1.5;
  message.theta = -0.5;
  return message;
}

template <>
map_meta_t sample() {
  map_meta_t message{};
  message.map_id = 3;
  message.tile_side = 64;
  message.tiles = 2;
  return message;
}

template <>
map_tile_t sample() {
  map_tile_t message{};
  message.map_id = 3;
  message.column = -2;
  message.side = 2;
  message.ncells = 4;
  message.cells = {1, 2, 3, 255};
  return message;
}

/// The message with the 32-bit word at `offset` replaced, cut or filled with zeros to `size` bytes.
Bytes patched(Bytes data, std::size_t offset, std::uint32_t word, std::size_t size) {
  for (std::size_t i = 0; i < 4; ++i) data.at(offset + i) = static_cast<std::uint8_t>(word >> (24 - 8 * i));
  data.resize(size);
  data.shrink_to_fit();  // so that the address sanitizer sees a read behind the end
  return data;
}

template <typename Message>
class DecodeChecked : public testing::Test {};
using Subscribed = testing::Types<scan_t, wheels_t, imu_t, command_t, ack_t, config_t, health_t, problems_t,
                                  pose_estimate_t, odometry_t, map_edit_t, map_meta_t, map_tile_t>;
TYPED_TEST_SUITE(DecodeChecked, Subscribed);

TYPED_TEST(DecodeChecked, ReadsWhatWasWritten) {
  const Bytes data = encoded(sample<TypeParam>());
  const auto decoded = decodeChecked<TypeParam>(data);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(encoded(*decoded), data);
}

TYPED_TEST(DecodeChecked, RefusesEveryTruncation) {
  const Bytes data = encoded(sample<TypeParam>());
  for (std::size_t size = 0; size < data.size(); ++size) {
    EXPECT_FALSE(decodeChecked<TypeParam>(Bytes(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(size))))
        << size << " of " << data.size() << " bytes";
  }
}

TYPED_TEST(DecodeChecked, RefusesBytesBehindTheMessage) {
  Bytes data = encoded(sample<TypeParam>());
  data.push_back(0);
  EXPECT_FALSE(decodeChecked<TypeParam>(data));
}

TYPED_TEST(DecodeChecked, RefusesAnotherFingerprint) {
  const Bytes good = encoded(sample<TypeParam>());
  for (std::size_t i = 0; i < 8; ++i) {
    Bytes data = good;
    data[i] ^= 0x10;
    EXPECT_FALSE(decodeChecked<TypeParam>(data));
  }
}

TYPED_TEST(DecodeChecked, SurvivesEveryFlippedBit) {
  const Bytes good = encoded(sample<TypeParam>());
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes data = good;
    data[bit / 8] = static_cast<std::uint8_t>(data[bit / 8] ^ (1U << (bit % 8)));
    const auto decoded = decodeChecked<TypeParam>(data);
    if (decoded) {
      EXPECT_EQ(static_cast<std::size_t>(decoded->getEncodedSize()), data.size());
    }
  }
}

TYPED_TEST(DecodeChecked, SurvivesRandomBytes) {
  std::mt19937 random(1);
  const Bytes good = encoded(sample<TypeParam>());
  for (int round = 0; round < 20'000; ++round) {
    Bytes data(random() % 200);
    for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random());
    EXPECT_FALSE(decodeChecked<TypeParam>(data));
    std::copy_n(good.begin(), std::min<std::size_t>(8, data.size()), data.begin());  // behind the right fingerprint
    const auto decoded = decodeChecked<TypeParam>(data);
    if (decoded) {
      EXPECT_EQ(static_cast<std::size_t>(decoded->getEncodedSize()), data.size());
    }
  }
}

TEST(DecodeCheckedScan, RefusesACountThatTheDatagramCannotHold) {
  const Bytes good = encoded(sample<scan_t>());
  constexpr std::size_t kCountOffset = 8 + 8 + 4 + 4;
  EXPECT_TRUE(decodeChecked<scan_t>(patched(good, kCountOffset, 3, good.size())));
  // 2 GiB, then counts whose size in bytes wraps around in 32 bits, then negative ones.
  for (const std::uint32_t count : {0x1FFFFFFFU, 0x10000000U, 0x10000003U, 0x40000000U, 0x40000003U, 0x7FFFFFFFU,
                                    0x80000000U, 0x80000003U, 0xFFFFFFFFU, 4U, 2U, 0U}) {
    for (const std::size_t size : {std::size_t{28}, std::size_t{34}, good.size()}) {
      if (count == 0 && size == 28) continue;  // that is a scan of no beams
      EXPECT_FALSE(decodeChecked<scan_t>(patched(good, kCountOffset, count, size))) << count << " in " << size;
    }
  }
}

TEST(DecodeCheckedTile, RefusesSidesAndCountsThatDoNotFit) {
  const Bytes good = encoded(sample<map_tile_t>());
  constexpr std::size_t kSideOffset = 8 + 8 + 3 * 4, kCountOffset = kSideOffset + 4;
  EXPECT_TRUE(decodeChecked<map_tile_t>(patched(good, kCountOffset, 4, good.size())));
  for (const std::uint32_t count : {0x7FFFFFFFU, 0x80000004U, 0xFFFFFFFFU, 5U, 3U, 0U})
    EXPECT_FALSE(decodeChecked<map_tile_t>(patched(good, kCountOffset, count, good.size()))) << count;
  for (const std::uint32_t side : {0U, 1U, 3U, 0xFFFFFFFEU, 0x10002U, 0x80000002U})  // two of them squared are 4, too
    EXPECT_FALSE(decodeChecked<map_tile_t>(patched(good, kSideOffset, side, good.size()))) << side;
}

TEST(DecodeCheckedWheels, RefusesACountThatTheDatagramCannotHold) {
  const Bytes good = encoded(sample<wheels_t>());
  constexpr std::size_t kCountOffset = 8 + 8 + 3 * 8 + 1;
  EXPECT_TRUE(decodeChecked<wheels_t>(patched(good, kCountOffset, 2, good.size())));
  for (const std::uint32_t count : {0x0FFFFFFFU, 0x20000002U, 0x7FFFFFFFU, 0x80000002U, 0xFFFFFFFFU, 3U, 1U, 0U}) {
    EXPECT_FALSE(decodeChecked<wheels_t>(patched(good, kCountOffset, count, good.size()))) << count;
  }
}

TEST(DecodeCheckedCommand, RefusesATextLengthThatTheDatagramCannotHold) {
  const Bytes good = encoded(sample<command_t>());
  constexpr std::size_t kVerbOffset = 8 + 8 + 4, kArgumentOffset = kVerbOffset + 4 + sizeof("save_map");
  for (const std::size_t offset : {kVerbOffset, kArgumentOffset}) {
    EXPECT_TRUE(decodeChecked<command_t>(patched(good, offset, 9, good.size())));
    // Length 0 lacks the final zero that each LCM text has; lcm-gen's decoder would take length - 1.
    for (const std::uint32_t length : {0U, 1U, 8U, 10U, 0x7FFFFFFFU, 0x80000009U, 0xFFFFFFFFU}) {
      EXPECT_FALSE(decodeChecked<command_t>(patched(good, offset, length, good.size()))) << length << " at " << offset;
    }
  }
}

TEST(DecodeCheckedCommand, RefusesAZeroInsideOfAText) {
  for (const std::size_t at : {std::size_t{8 + 8 + 4 + 4 + 3}, 8 + 8 + 4 + 4 + sizeof("save_map") + 4}) {
    Bytes data = encoded(sample<command_t>());
    ASSERT_NE(data.at(at), 0);
    data[at] = 0;
    EXPECT_FALSE(decodeChecked<command_t>(data)) << at;
  }
}

TEST(DecodeCheckedWheels, RefusesMoreWheelsThanABaseHas) {
  for (const int wheels : {0, 8, 9, 1000}) {
    wheels_t message = sample<wheels_t>();
    message.nwheels = wheels;
    message.angles.assign(static_cast<std::size_t>(wheels), 1.0);
    EXPECT_EQ(decodeChecked<wheels_t>(encoded(message)).has_value(), wheels <= 8) << wheels;
  }
}

TEST(DecodeCheckedDepth, RefusesMoreBeamsAndSurfacesThanItHasRoomFor) {
  const auto taken = [](int beams, int surfaces) {
    depth_t message{};
    message.utime = 1;
    message.nbeams = beams;
    message.ranges.resize(static_cast<std::size_t>(beams));
    message.free_from.resize(static_cast<std::size_t>(beams));
    message.kinds.resize(static_cast<std::size_t>(beams));
    message.nsurfaces = surfaces;
    message.surface_beams.resize(static_cast<std::size_t>(surfaces));
    message.surface_from.resize(static_cast<std::size_t>(surfaces));
    message.surface_to.resize(static_cast<std::size_t>(surfaces));
    return decodeChecked<depth_t>(encoded(message)).has_value();
  };
  EXPECT_TRUE(taken(PseudoLaser::kCapacity, PseudoLaser::kSurfaceCapacity));
  EXPECT_FALSE(taken(PseudoLaser::kCapacity + 1, 0));
  EXPECT_FALSE(taken(0, PseudoLaser::kSurfaceCapacity + 1));
}

TEST(DecodeCheckedHealth, RefusesLessThanNothing) {
  health_t message{};
  message.summary = "pose lost";
  const Bytes good = encoded(message);
  ASSERT_TRUE(decodeChecked<health_t>(good));
  // Three counts of nothing end the message.
  for (const std::size_t from_end : {std::size_t{4}, std::size_t{8}, std::size_t{12}}) {
    for (const std::uint32_t count : {0xFFFFFFFFU, 0x80000000U}) {
      EXPECT_FALSE(decodeChecked<health_t>(patched(good, good.size() - from_end, count, good.size()))) << from_end;
    }
  }
}

}  // namespace
}  // namespace slam::checked_decode_test
