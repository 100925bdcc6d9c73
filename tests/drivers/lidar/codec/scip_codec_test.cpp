// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/scip_codec.hpp"

#include <gtest/gtest.h>

namespace slam::scip::scip_codec_test {
namespace {

constexpr int kTurn = 360 * 64;  // [deg/64]

Answer answerOf(std::vector<std::string> lines) { return {"00", std::move(lines)}; }

// Of Hokuyo's wiki for the URG-04LX, as printed there.
const Answer kUrg = answerOf({"MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N", "DMIN:20;4", "DMAX:5600;_", "ARES:1024;\\",
                              "AMIN:44;7", "AMAX:725;o", "AFRT:384;6", "SCAN:600;e"});

TEST(ScipCodec, ReadsTheValuesOfTheMakersDocument) {  // computed by its rules
  EXPECT_EQ(decode("CB"), 1234U);
  EXPECT_EQ(decode("1Dh"), 5432U);
  EXPECT_EQ(decode("m2@0"), 16000000U);
  EXPECT_EQ(encode(1234, 2), "CB");
  EXPECT_EQ(encode(5432, 3), "1Dh");
  EXPECT_EQ(encode(16000000, 4), "m2@0");
  EXPECT_EQ(encode(1000, 3) + encode(1005, 3) + encode(0, 3), "0?X0?]000");
  EXPECT_EQ(sumOf("0?X0?]000"), 'S');
}

TEST(ScipCodec, FindsTheSumRight) {
  for (const char* line : {"m2@0?", "00P", "99b", "02R", "0Ee", "10Q"}) EXPECT_TRUE(sumFits(line)) << line;
  for (const char* line : {"m2@1?", "00Q", "", "P"}) EXPECT_FALSE(sumFits(line)) << line;
}

TEST(ScipCodec, ReadsARealUnitsAnswer) {  // recorded of a URG-04LX-UG01
  const Answer version =
      answerOf({"VEND:Hokuyo Automatic Co.,Ltd.;[", "PROD:SOKUIKI Sensor URG-04LX-UG01(Simple-URG);[",
                "FIRM:3.4.03(17/Dec./2012);T", "PROT:SCIP 2.0;N", "SERI:H1510998;V"});
  EXPECT_EQ(valueOf(version, "VEND"), "Hokuyo Automatic Co.,Ltd.");
  EXPECT_EQ(valueOf(version, "FIRM"), "3.4.03(17/Dec./2012)");
  EXPECT_EQ(valueOf(version, "SERI"), "H1510998");
  EXPECT_EQ(valueOf(version, "NONE"), "");
  EXPECT_EQ(valueOf(answerOf({"SERI:H1510999;V"}), "SERI"), "") << "a wrong sum";
}

TEST(ScipCodec, ReadsWhatAUnitMeasures) {
  const auto urg = parseParameters(kUrg);
  ASSERT_TRUE(urg);
  EXPECT_EQ(urg->steps(), 682);
  EXPECT_NEAR(urg->turnTime(), 0.1, 1e-9);
  EXPECT_EQ(urg->angleQ6(384), 0);
  EXPECT_EQ(urg->angleQ6(384 + 256), kTurn / 4) << "counter-clockwise";
  EXPECT_EQ(urg->angleQ6(384 - 256), 3 * kTurn / 4);
  EXPECT_EQ(scanCommand(*urg), "MD0044072501000");
  const auto ust = parseParameters(answerOf({"MODL:UST-10LX;D", "DMIN:20;4", "DMAX:30000;G", "ARES:1440;^", "AMIN:0;?",
                                             "AMAX:1080;Z", "AFRT:540;0", "SCAN:2400;U"}));  // computed
  ASSERT_TRUE(ust);
  EXPECT_EQ(ust->steps(), 1081);
  EXPECT_NEAR(ust->stepTime(), 0.025 / 1440, 1e-12);
}

TEST(ScipCodec, RefusesParametersThatCannotBe) {
  const auto with = [](const std::string& line) {
    Answer answer = kUrg;
    for (std::string& old : answer.lines) {
      if (old.starts_with(line.substr(0, 5))) old = line + ";" + sumOf(line);
    }
    return parseParameters(answer).has_value();
  };
  EXPECT_TRUE(with("ARES:1024"));
  for (const char* line : {"ARES:0", "ARES:-5", "ARES:999999999999", "ARES:1024x", "ARES:", "AMIN:725", "AMAX:44",
                           "AMAX:1100", "AMAX:99999", "AFRT:-1", "DMAX:20", "SCAN:0", "SCAN:1000000"})
    EXPECT_FALSE(with(line)) << line;
  Answer missing = kUrg;
  missing.lines.pop_back();
  EXPECT_FALSE(parseParameters(missing));
}

TEST(ScipCodec, FindsAnAnswerBehindWhatAnOldScanLeft) {
  std::size_t size = 0;
  const std::string old = "0?X0?]000S\nPP\nx\n\nMD0044072501000\n99b\n", answer = "VV\n00P\nPROT:SCIP 2.0;N\n\n";
  EXPECT_FALSE(findAnswer(old, "VV", size));
  EXPECT_FALSE(findAnswer(old + "VV\n00P\nPROT:SCIP 2.0;N\n", "VV", size)) << "its end is missing";
  const auto found = findAnswer(old + answer + "next", "VV", size);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->status, "00");
  EXPECT_EQ(valueOf(*found, "PROT"), "SCIP 2.0");
  EXPECT_EQ(size, old.size() + answer.size());
  EXPECT_FALSE(findAnswer("xVV\n00P\n\n", "VV", size)) << "within a line";
  const auto wrong = findAnswer("BM\n02S\n\n", "BM", size);
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->status, "") << "a wrong sum";
}

}  // namespace
}  // namespace slam::scip::scip_codec_test
