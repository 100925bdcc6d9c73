// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/rplidar_modes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>

namespace slam::rplidar::rplidar_modes_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::ElementsAre;

// ---- Requests and answers: DEVICES.md 1.2 and 1.4

TEST(ConfigurationRequest, IsThatOfTheProtocolByteForByte) {
  EXPECT_THAT(encodeConfigurationRequest(ConfigurationEntry::kModeCount),
              ElementsAre(0xA5, 0x84, 0x04, 0x70, 0, 0, 0, 0x55));
  EXPECT_THAT(encodeConfigurationRequest(ConfigurationEntry::kTypicalMode),
              ElementsAre(0xA5, 0x84, 0x04, 0x7C, 0, 0, 0, 0x59));
  EXPECT_THAT(encodeConfigurationRequest(ConfigurationEntry::kSampleTime, 3),
              ElementsAre(0xA5, 0x84, 0x06, 0x71, 0, 0, 0, 3, 0, 0x55));
  EXPECT_THAT(encodeConfigurationRequest(ConfigurationEntry::kAnswerType, 3),
              ElementsAre(0xA5, 0x84, 0x06, 0x75, 0, 0, 0, 3, 0, 0x51));
}

TEST(ConfigurationAnswer, MustEchoItsEntry) {
  const Bytes data{0x70, 0, 0, 0, 5, 0};
  const auto payload = parseConfiguration(ConfigurationEntry::kModeCount, data);
  ASSERT_TRUE(payload);
  EXPECT_EQ(parseModeNumber(*payload), 5);
  EXPECT_FALSE(parseConfiguration(ConfigurationEntry::kTypicalMode, data));
  EXPECT_FALSE(parseConfiguration(ConfigurationEntry::kModeCount, Bytes{0x70, 0, 0}));
  EXPECT_FALSE(parseConfiguration(ConfigurationEntry::kModeCount, {}));
}

TEST(ConfigurationAnswer, ValuesOfARealA1) {
  EXPECT_DOUBLE_EQ(*parseSampleTime(Bytes{0x00, 0xFC, 0x01, 0}), 508e-6);  // 130048
  EXPECT_DOUBLE_EQ(*parseSampleTime(Bytes{0x00, 0x7F, 0x00, 0}), 127e-6);  // 32512
  EXPECT_DOUBLE_EQ(*parseSampleTime(Bytes{0x00, 0xC9, 0x00, 0}), 201e-6);  // 51456
  EXPECT_DOUBLE_EQ(*parseMaxDistance(Bytes{0x00, 0x0C, 0, 0}), 12.0);      // 3072
  EXPECT_EQ(parseAnswerType(Bytes{0x84}), 0x84);
}

TEST(ConfigurationAnswer, ValuesOutsideTheProtocolAreRefused) {
  EXPECT_FALSE(parseSampleTime(Bytes{0, 0, 0, 0})) << "samples without end";
  EXPECT_FALSE(parseSampleTime(Bytes{0xFF, 0xFF, 0xFF, 0xFF}));
  EXPECT_FALSE(parseSampleTime(Bytes{0, 0x7F, 0}));
  EXPECT_FALSE(parseModeNumber(Bytes{5}));
  EXPECT_FALSE(parseAnswerType(Bytes{}));
  EXPECT_FALSE(parseAnswerType(Bytes{0x84, 0}));
  EXPECT_FALSE(parseMaxDistance(Bytes{0}));
}

TEST(ModeNameOfADevice, IsCopiedNoFurtherThanItHasRoom) {
  EXPECT_STREQ(parseModeName(Bytes{'B', 'o', 'o', 's', 't', 0, 'X'}).data(), "Boost");
  EXPECT_STREQ(parseModeName({}).data(), "");
  const ModeName name = parseModeName(Bytes(250, 'A'));  // without a zero, longer than the room
  EXPECT_EQ(std::string(name.data()), std::string(kModeNameSize - 1, 'A'));
  EXPECT_STREQ(parseModeName(Bytes{'a', 0x1B, 0xC3, 'b'}).data(), "a??b") << "no control sequences into logs";
}

// ---- Choice

constexpr SampleRate kRate{508, 254};
constexpr std::uint16_t kFirmware129 = 0x011D;

ScanMode mode(std::uint16_t id, std::uint8_t type, double us) {
  return {.id = id, .by_express = true, .answer_type = type, .sample_time = 1e-6 * us};
}

std::vector<ScanMode> listOf129() {
  return {mode(0, 0x81, 508), mode(1, 0x82, 254), mode(2, 0x84, 127), mode(3, 0x84, 127), mode(4, 0x84, 201)};
}

std::vector<int> ids(const std::vector<ScanMode>& modes) {
  std::vector<int> result;
  for (const ScanMode& m : modes) result.push_back(m.by_express ? m.id : -1);
  return result;
}

TEST(ModesToTry, DensestFirstTheTypicalOneOfEquallyDenseOnesStandardLast) {
  const auto list = listOf129();
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, kFirmware129, kRate, list, 3)), ElementsAre(3, 2, 4, 1, -1));
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, kFirmware129, kRate, list, 2)), ElementsAre(2, 3, 4, 1, -1));
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, kFirmware129, kRate, list, {})), ElementsAre(2, 3, 4, 1, -1));
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, kFirmware129, kRate, list, 1)), ElementsAre(2, 3, 4, 1, -1))
      << "typical counts among equals alone";
}

TEST(ModesToTry, PassesOverAnswersThatItCannotRead) {
  auto list = listOf129();
  list.push_back(mode(5, 0x83, 31));  // HQ
  list.push_back(mode(6, 0x87, 31));
  list.push_back(mode(7, 0x85, 100));
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, kFirmware129, kRate, list, 5)), ElementsAre(7, 2, 3, 4, 1, -1));
}

TEST(ModesToTry, WithoutAListTakeExpressFromFirmware117On) {
  const auto modern = modesToTry(ModeWish::kDensest, 0x0116, kRate, {}, {});
  EXPECT_THAT(ids(modern), ElementsAre(0, -1));
  EXPECT_DOUBLE_EQ(modern[0].sample_time, 254e-6);
  EXPECT_DOUBLE_EQ(modern[1].sample_time, 508e-6);
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, 0x0111, kRate, {}, {})), ElementsAre(0, -1));
  EXPECT_THAT(ids(modesToTry(ModeWish::kDensest, 0x0110, kRate, {}, {})), ElementsAre(-1));
}

TEST(ModesToTry, AWishIsFollowedAlone) {
  const auto list = listOf129();
  EXPECT_THAT(ids(modesToTry(ModeWish::kStandard, kFirmware129, kRate, list, 3)), ElementsAre(-1));
  const auto express = modesToTry(ModeWish::kExpress, kFirmware129, kRate, list, 3);
  EXPECT_THAT(ids(express), ElementsAre(1));
  EXPECT_DOUBLE_EQ(express[0].sample_time, 254e-6);
  EXPECT_THAT(ids(modesToTry(ModeWish::kExpress, 0x0116, kRate, {}, {})), ElementsAre(0));
}

TEST(RplidarModes, FirmwareIsComparedWithinTheASeriesAlone) {
  for (const int model : {0x18, 0x28, 0x31}) {
    EXPECT_EQ(comparableFirmware({.model = static_cast<std::uint8_t>(model), .firmware = 0x0101}), 0x0101);
  }
  for (const int model : {0x41, 0x61, 0x71, 0x81, 0x91, 0xF0, 0x02}) {
    const DeviceInfo info{.model = static_cast<std::uint8_t>(model), .firmware = 0x0100};
    EXPECT_GE(comparableFirmware(info), kFirmwareWithModes) << model;
  }
}

TEST(RplidarModes, NamesTheModel) {
  EXPECT_EQ(modelName(0x18), "RPLidar A1 (model 0x18)");
  EXPECT_EQ(modelName(0x41), "RPLidar C1 (model 0x41)");
  EXPECT_EQ(modelName(0x81), "RPLidar S3 (model 0x81)");
  EXPECT_EQ(modelName(0xB2), "RPLidar (model 0xb2)");
}

}  // namespace
}  // namespace slam::rplidar::rplidar_modes_test
