// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/cola_codec.hpp"

#include <gtest/gtest.h>

namespace slam::cola::cola_codec_test {
namespace {

constexpr int kTurn = 360 * 64;  // [deg/64]

// The example of the maker's manual, in the form of a recorded telegram: 21 beams from 10 deg by half a degree.
const std::string kExample =
    "sRA LMDscandata 1 1 89A27F 0 0 343 347 27477BA9 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 3F800000 00000000 186A0 "
    "1388 "
    "15 8A1 8A5 8AB 8AC 8A6 8AC 8B6 8C8 8C2 8C9 8CB 8C4 8E4 8E1 8EB 8E0 8F5 908 8FC 907 906 0 0 0 0 0 0";
// How telegrams of real units began, as published; their ranges are not, so that these are made up.
const std::string kTim571 =
    "sRA LMDscandata 1 1 1078AAA 0 0 BFD BFF CFACE0D CFAE156 0 0 1 0 0 5DC A2 0 1 DIST1 3F800000 00000000 FFF92230 D05 "
    "32B 24B 257";
const std::string kTim551 =
    "sRA LMDscandata 1 1 F510AB 0 0 5932 5933 5B87697D 5B88808C 0 0 1 0 0 5DC 36 0 1 DIST1 3F800000 00000000 FFF92230 "
    "2710 10F 292 290 28D";
const std::string kLms =
    "sSN LMDscandata 1 1 A037B9 0 0 C1C3 C1C6 8B621C37 8B627603 0 0 7 0 0 1388 168 0 1 DIST1 3F800000 00000000 "
    "FFF92230 "
    "1388 21D 293 272";

TEST(ColaCodec, ReadsTheMakersExample) {
  auto scan = parseScan(kExample);
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->beams, 21);
  EXPECT_DOUBLE_EQ(scan->first, -80.0) << "10 deg, where 90 is ahead";
  EXPECT_EQ(scan->per_turn, 720);
  EXPECT_DOUBLE_EQ(scan->turn_time, 0.02);
  EXPECT_EQ(scan->began_us, 0x27477BA9U);
  EXPECT_EQ(scan->scale, 1.0);
  EXPECT_EQ(scan->contamination, Contamination::kNone);
  EXPECT_EQ(takeNumber(scan->values), 2209U);
  EXPECT_EQ(takeNumber(scan->values), 2213U);
}

TEST(ColaCodec, ReadsTheHeadsOfRealUnits) {
  const auto tim571 = parseScan(kTim571), tim551 = parseScan(kTim551), lms = parseScan(kLms);
  ASSERT_TRUE(tim571 && tim551 && lms);
  EXPECT_EQ(tim571->beams, 811);
  EXPECT_EQ(tim571->per_turn, 1080) << "a third of a degree, printed as 0.3333";
  EXPECT_EQ(tim571->angleQ6(0), (kTurn - 135 * 64) % kTurn);
  EXPECT_EQ(tim571->angleQ6(405), 0);
  EXPECT_EQ(tim571->angleQ6(810), 135 * 64) << "counter-clockwise, and no error adds up";
  EXPECT_NEAR(tim571->turn_time, 1.0 / 15.0, 1e-9);
  EXPECT_EQ(tim551->beams, 271);
  EXPECT_EQ(tim551->per_turn, 360);
  EXPECT_EQ(lms->beams, 541);
  EXPECT_DOUBLE_EQ(lms->turn_time, 0.02);
  EXPECT_FALSE(tim571->isLike(*tim551));
}

TEST(ColaCodec, ReadsItsOtherFields) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kExample;
    text.replace(text.find(from), from.size(), to);
    return parseScan(text);
  };
  EXPECT_EQ(with(" 0 0 343", " 0 2 343")->contamination, Contamination::kWarning);
  EXPECT_EQ(with(" 0 0 343", " 0 5 343")->contamination, Contamination::kError);
  EXPECT_EQ(with("3F800000", "40000000")->scale, 2.0);
  EXPECT_EQ(with("168 0 1 ", "168 1 1234 5 1 ")->beams, 21) << "with an encoder";
}

TEST(ColaCodec, RefusesWhatCannotBe) {
  const auto refused = [](const std::string& from, const std::string& to) {
    std::string text = kExample;
    text.replace(text.find(from), from.size(), to);
    return !parseScan(text);
  };
  EXPECT_TRUE(refused("sRA", "sWA"));
  EXPECT_TRUE(refused("LMDscandata", "LMDscandat"));
  EXPECT_TRUE(refused("DIST1", "RSSI1"));
  EXPECT_TRUE(refused(" 15 8A1", " 0 8A1")) << "no beam";
  EXPECT_TRUE(refused(" 15 8A1", " FFFF 8A1")) << "more beams than a turn has";
  EXPECT_TRUE(refused(" 15 8A1", " FFFFFFFFFF 8A1"));
  EXPECT_TRUE(refused("1388 15", "0 15")) << "no step";
  EXPECT_TRUE(refused("1388 15", "1 15")) << "a step too small";
  EXPECT_TRUE(refused("1388 168", "0 168")) << "no turns";
  EXPECT_TRUE(refused("168 0 1", "168 FFFF 1")) << "encoders without end";
  EXPECT_TRUE(refused("3F800000", "7F800000")) << "an infinite scale";
  EXPECT_TRUE(refused("3F800000", "7FC00000")) << "no number";
  EXPECT_TRUE(refused("3F800000", "BF800000"));
  EXPECT_TRUE(refused("27477BA9", "27477BX9"));
  EXPECT_FALSE(parseScan(""));
  for (std::size_t size = 0; size < kExample.find(" 15 8A1"); ++size) EXPECT_FALSE(parseScan(kExample.substr(0, size)));
}

TEST(ColaCodec, FindsATelegramAmongOthers) {
  std::size_t size = 0;
  const std::string bytes = "noise" + telegram("sSN LMDscandata 1") + telegram("sRA DeviceIdent 3 TIM") + "\x02sR";
  const auto found = findTelegram(bytes, "sRA DeviceIdent ", "sFA", size);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, "sRA DeviceIdent 3 TIM");
  EXPECT_EQ(size, bytes.size() - 3);
  EXPECT_EQ(findTelegram(telegram("sFA 1"), "sRA DeviceIdent ", "sFA", size), "sFA 1");
  EXPECT_FALSE(findTelegram("\x02sRA DeviceIdent 3", "sRA DeviceIdent ", "sFA", size)) << "its end is missing";
}

}  // namespace
}  // namespace slam::cola::cola_codec_test
