// SPDX-License-Identifier: BSD-3-Clause
#include "app/device_monitor.hpp"

#include <atomic>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/log_lines.hpp"
#include "problems/devices.hpp"
#include "support/problems.hpp"

namespace slam::device_monitor_test {
namespace {

using namespace std::chrono_literals;
using test::problemOf;
using testing::ElementsAre;
using testing::IsEmpty;
constexpr Timestamp kNow{1000s};

/// A lidar of 10 Hz whose driver streams.
struct Lidar {
  DeviceStatus status;
  WatchedDevice device{"lidar", &status, 10.0};

  Lidar() { status.set(DeviceState::kStreaming); }
  std::string reason(Timestamp now = kNow) const {
    const Problem problem = slam::problemOf(device, status.problem(), now);
    return problem ? silenceOf(device, now) + problem.words() : "";
  }
  /// Samples of the second that ends now.
  void measure(int samples, Timestamp now = kNow, bool settled = true) {
    for (int i = 0; i < samples; ++i) status.countSample(now);
    measureRate(device, 1.0, settled, now);
  }
};

TEST(DeviceHealth, IsStaleWithoutASampleForNineTenthsOfASecond) {
  Lidar lidar;
  EXPECT_FALSE(ageOf(lidar.device, kNow)) << "none came yet";
  EXPECT_EQ(stateOf(lidar.device, kNow), DeviceState::kStreaming);
  EXPECT_EQ(lidar.reason(), "");
  lidar.status.countSample(kNow);
  EXPECT_EQ(stateOf(lidar.device, kNow + 900ms), DeviceState::kStreaming);
  EXPECT_EQ(stateOf(lidar.device, kNow + 901ms), DeviceState::kStale);
  EXPECT_EQ(lidar.reason(kNow + 900ms), "");
  EXPECT_EQ(lidar.reason(kNow + 1300ms), "no data for 1.3 s, port present, but silent: pull its plug");
  EXPECT_EQ(ageOf(lidar.device, kNow + 1300ms), Duration(1300ms));
  for (const DeviceState other : {DeviceState::kAbsent, DeviceState::kOpening, DeviceState::kFault}) {
    lidar.status.set(other, problemOf("no such port"));
    EXPECT_EQ(stateOf(lidar.device, kNow + 5s), other) << "the driver knows better";
  }
  EXPECT_EQ(lidar.reason(kNow + 5s), "no data for 5.0 s, no such port");
}

TEST(DeviceHealth, LetsOthersWhoSendOverLcmTakeTwoSeconds) {
  Lidar lidar;
  lidar.device.over_lcm = true;
  lidar.status.countSample(kNow);
  EXPECT_EQ(stateOf(lidar.device, kNow + 2s), DeviceState::kStreaming);
  EXPECT_EQ(stateOf(lidar.device, kNow + 2001ms), DeviceState::kStale);
  EXPECT_EQ(lidar.reason(kNow + 2500ms),
            "no data for 2.5 s, nobody sends it over LCM: start the program that sends it; both need one lcm.url");
}

TEST(DeviceHealth, ReportsThatSamplesComeTooSeldom) {
  for (const auto& [samples, slow] : {std::pair(10, false), {7, false}, {6, true}, {1, true}}) {
    Lidar lidar;
    lidar.measure(10);
    lidar.measure(samples);
    EXPECT_EQ(lidar.device.rate, samples);
    EXPECT_EQ(lidar.reason(),
              slow
                  ? std::to_string(samples) +
                        ".0 Hz where 10.0 Hz are expected, and nothing is damaged on the line; slamd goes on with what "
                        "comes; fix: check at which rate the device is set to send, and its power"
                  : "");
  }
}

TEST(DeviceHealth, IsNotBlamedForAnOverloadedComputer) {
  Lidar lidar;
  lidar.device.starved = true;
  lidar.measure(10);
  lidar.measure(1);
  EXPECT_EQ(lidar.reason(), "") << "it may have sent more";
  EXPECT_EQ(lidar.reason(kNow + 1300ms), "no data for 1.3 s, the computer is overloaded: end other programs (top)");
  lidar.status.setProblem(problemOf("no such port"));
  EXPECT_EQ(lidar.reason(kNow + 1300ms), "no data for 1.3 s, no such port");
  lidar.status.setProblem(problem::kBoardLate);
  EXPECT_EQ(lidar.reason(), "the computer is overloaded: end other programs (top)");
  lidar.device.starved = false;
  EXPECT_THAT(lidar.reason(), testing::HasSubstr("come too late: is something else on its link"));
}

TEST(DeviceHealth, ReportsThatALineLosesBytes) {
  Lidar lidar;
  lidar.measure(10);
  lidar.status.rejects += 4;
  lidar.measure(4);
  EXPECT_THAT(lidar.reason(),
              testing::AllOf(testing::HasSubstr("4.0 a second are lost or damaged on the line"),
                             testing::HasSubstr("check the cable"), testing::Not(testing::HasSubstr("CPU"))));
  lidar.measure(10);
  lidar.measure(4);
  EXPECT_THAT(lidar.reason(), testing::HasSubstr("nothing is damaged")) << "what was damaged before does not count";
}

TEST(DeviceHealth, EvaluatesNoRateOfASecondInWhichTheDeviceCameOrWent) {
  Lidar lidar;
  lidar.measure(3);
  EXPECT_FALSE(lidar.device.rate_valid) << "it came";
  lidar.measure(3);
  EXPECT_TRUE(lidar.device.rate_valid);
  lidar.measure(3, kNow, /*settled=*/false);
  EXPECT_FALSE(lidar.device.rate_valid) << "slamd has just begun";
  lidar.measure(3);
  lidar.status.set(DeviceState::kOpening, problemOf("looking for it"));
  lidar.measure(3);
  EXPECT_FALSE(lidar.device.rate_valid) << "it went";
  EXPECT_EQ(lidar.reason(), "looking for it");
  lidar.status.set(DeviceState::kStreaming);
  lidar.measure(3);
  EXPECT_FALSE(lidar.device.rate_valid);
  lidar.measure(3);
  EXPECT_TRUE(lidar.device.rate_valid);
  lidar.measure(0, kNow + 901ms);
  EXPECT_FALSE(lidar.device.rate_valid) << "silent";
}

TEST(DeviceHealth, MeasuresRatesOverTheTimeThatPassed) {
  Lidar lidar;
  for (int i = 0; i < 30; ++i) lidar.status.countSample(kNow);
  measureRate(lidar.device, 2.0, true, kNow);
  EXPECT_EQ(lidar.device.rate, 15.0);
  measureRate(lidar.device, 2.0, true, kNow);
  EXPECT_EQ(lidar.device.rate, 0.0) << "of the samples since then";
}

class Monitor : public testing::Test {
 protected:
  Monitor() { monitor.add({.name = "lidar", .status = &status, .expected = 10.0, .without = "goes on by wheels"}); }
  std::vector<std::string> look(Duration later) {
    monitor.look(kNow + later);
    std::vector<std::string> texts;
    for (const LogLine& line : monitor.arrivals(log, kNow + later)) texts.push_back(line.text);
    for (const LogLine& line : log.look(monitor.troubles(kNow + later), kNow + later)) texts.push_back(line.text);
    return texts;
  }
  std::vector<std::string> lookFor(Duration begin, Duration end, Duration step = 100ms) {
    std::vector<std::string> texts;
    for (Duration at = begin; at < end; at += step)
      for (std::string& text : look(at)) texts.push_back(std::move(text));
    return texts;
  }
  void stream(Duration at) {
    status.set(DeviceState::kStreaming);
    status.countSample(kNow + at);
  }

  std::atomic<bool> lidar_stuck{false};
  DeviceStatus status;
  DeviceMonitor monitor{lidar_stuck};
  TroubleLog log;
};

TEST_F(Monitor, LogsNewsOnceAndTriesToOpenNotAtAll) {
  status.set(DeviceState::kAbsent, problemOf("no such port"));
  EXPECT_THAT(look(0s), ElementsAre("lidar ABSENT: no such port; slamd goes on by wheels"));
  EXPECT_THAT(look(100ms), IsEmpty());
  status.setOpening(problemOf("opening"));
  EXPECT_THAT(lookFor(200ms, 2s), IsEmpty()) << "it is tried again and again";
  std::vector<std::string> texts;
  for (Duration at = 2s; at < 8s; at += 100ms) {
    stream(at);
    for (const std::string& text : look(at)) texts.push_back(text + " at " + std::to_string(at / 1ms));
  }
  EXPECT_THAT(texts, ElementsAre("lidar STREAMING at 7000"));
  EXPECT_THAT(lookFor(8s, 9s), ElementsAre(testing::StartsWith("lidar STALE: no data for 1.0 s")));
  status.set(DeviceState::kFault, problemOf("wedged"));
  EXPECT_THAT(look(9s), ElementsAre(testing::HasSubstr("wedged"))) << "another reason";
}

TEST_F(Monitor, GoesOnByNothingThatIsAwayItself) {
  DeviceStatus base;
  monitor.add(
      {.name = "base", .status = &base, .expected = 50.0, .without = "goes on by scan matching", .by = "lidar"});
  const auto words = [&](Duration at) {
    std::vector<std::string> texts;
    for (const Trouble& trouble : monitor.problems(kNow + at)) texts.push_back(trouble.text());
    return texts;
  };
  base.set(DeviceState::kAbsent, problemOf("no such port"));
  stream(0s);
  EXPECT_THAT(words(0s), ElementsAre("base: no such port; slamd goes on by scan matching"));
  status.set(DeviceState::kAbsent, problemOf("gone"));
  EXPECT_THAT(words(100ms), ElementsAre("lidar: gone; slamd goes on by wheels", "base: no such port"));
}

TEST_F(Monitor, LogsTheFirstSampleOfADeviceThatWasNotMissed) {
  status.set(DeviceState::kOpening, problemOf("opening"));
  EXPECT_THAT(lookFor(0s, 2s), IsEmpty());
  stream(2s);
  EXPECT_THAT(look(2s), ElementsAre("lidar STREAMING"));
}

TEST_F(Monitor, NamesADeviceThatNeverOpensWithinThreeSeconds) {
  status.set(DeviceState::kOpening, problemOf("waiting for the motor's speed"));
  EXPECT_THAT(lookFor(0s, 2900ms), IsEmpty());
  EXPECT_THAT(lookFor(2900ms, 10s),
              ElementsAre("lidar OPENING: waiting for the motor's speed; slamd goes on by wheels"));
}

TEST_F(Monitor, HasNewsForHealthAtOnceButNotMoreThanEveryTwoSecondsForLong) {
  int news = 0;
  for (int i = 0; i < 600; ++i) {  // a minute
    status.set(DeviceState::kFault, problemOf(i % 2 == 0 ? "too hot" : "too cold"));
    news += monitor.look(kNow + i * 100ms) ? 1 : 0;
  }
  EXPECT_NEAR(news, 10 + 30, 2);
}

TEST_F(Monitor, LogsWhoEachDeviceIsOnce) {
  status.identify("an A1");
  EXPECT_THAT(look(0s), testing::Contains("lidar: an A1"));
  status.identify("an A1");
  EXPECT_THAT(look(10s), testing::Not(testing::Contains("lidar: an A1"))) << "connected again";
  status.identify("an S3");
  EXPECT_THAT(look(20s), testing::Contains("lidar: an S3")) << "another one";
}

/// What a driver shows of a fault that lasts, at a time since its beginning.
struct Fault {
  const char* kind;
  void (*at)(DeviceStatus&, Duration, Timestamp);
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.kind; }

void stream(DeviceStatus& status, Timestamp now, const Problem& problem = {}) {
  status.countSample(now);
  status.set(DeviceState::kStreaming, problem);
}

class DeviceDay : public testing::TestWithParam<Fault> {};

TEST_P(DeviceDay, HasFewLinesTheFirstWithinAFewSecondsAndOneRecovery) {
  const Fault& fault = GetParam();
  std::atomic<bool> stuck{false};
  DeviceStatus status;
  DeviceMonitor monitor(stuck);
  monitor.add({.name = "it", .status = &status, .expected = 2.0, .without = "goes on"});
  TroubleLog log;
  std::vector<test::LoggedLine> lines;
  const auto look = [&](Duration at) {
    monitor.look(kNow + at);
    if (at % 1s == 0s) monitor.measureRates(1.0, true, kNow + at);
    for (const LogLine& line : monitor.arrivals(log, kNow + at)) lines.push_back({at, line});
    for (const LogLine& line : log.look(monitor.troubles(kNow + at), kNow + at)) lines.push_back({at, line});
  };
  constexpr Duration kStep = 500ms;
  for (Duration at = -30s; at < 0s; at += kStep) stream(status, kNow + at), look(at);
  ASSERT_EQ(lines.size(), 1U) << "it streams";
  lines.clear();
  for (Duration at = 0s; at < 24h; at += kStep) fault.at(status, at, kNow + at), look(at);
  ASSERT_FALSE(lines.empty());
  EXPECT_LE(lines.front().at, 3s);
  EXPECT_LE(test::mostWithinAnHour(lines), 20);
  EXPECT_LT(lines.size(), 500U);
  std::printf("%-36s %3zu lines, %2d within an hour\n", fault.kind, lines.size(), test::mostWithinAnHour(lines));
  lines.clear();
  for (Duration at = 24h; at < 24h + 1min; at += kStep) stream(status, kNow + at), look(at);
  const bool said = log.isOpen("it");
  EXPECT_FALSE(said) << "the last line says that it streams";
  EXPECT_LE(lines.size(), 1U);
  for (const test::LoggedLine& line : lines) EXPECT_EQ(line.line.text, "it STREAMING");
}

INSTANTIATE_TEST_SUITE_P(
    OfEachKind, DeviceDay,
    testing::Values(
        Fault{"off",
              [](DeviceStatus& status, Duration at, Timestamp) {
                at / 500ms % 2 == 0 ? status.set(DeviceState::kAbsent, problemOf("no such port"))
                                    : status.setOpening(problemOf("opening"));
              }},
        Fault{"stuck",
              [](DeviceStatus& status, Duration, Timestamp) { status.set(DeviceState::kStale, problemOf("stuck")); }},
        Fault{"garbage",
              [](DeviceStatus& status, Duration at, Timestamp) {
                const char* const words[] = {"no data", "bytes come, but no answer", "bytes come, but no measurements"};
                at / 1s % 7 < 3 ? status.set(DeviceState::kFault, problemOf(words[at / 1s % 3]))
                                : status.setOpening(problemOf("opening"));
              }},
        Fault{"slow",
              [](DeviceStatus& status, Duration at, Timestamp now) {
                if (at % 1s == 500ms) stream(status, now);
              }},
        Fault{"crowded",
              [](DeviceStatus& status, Duration, Timestamp now) { stream(status, now, problemOf("every second")); }},
        Fault{"intermittent",
              [](DeviceStatus& status, Duration at, Timestamp now) {
                at / 3s % 2 == 0 ? status.set(DeviceState::kAbsent, problemOf("the port is gone"))
                                 : stream(status, now);
              }},
        Fault{"without power: STALE and FAULT in turn",
              [](DeviceStatus& status, Duration at, Timestamp) {
                at / 500ms % 2 == 0
                    ? status.set(DeviceState::kStale, problemOf("the board does not answer: check its power"))
                    : status.set(DeviceState::kFault, problemOf("no answer: check power and baud rate"));
              }},
        Fault{"motor unplugged: a scan without data",
              [](DeviceStatus& status, Duration at, Timestamp) {
                at / 1s % 5 == 4
                    ? status.set(DeviceState::kStale, problemOf("scan accepted, but no data: check the motor's plug"))
                    : status.setOpening(problemOf("waiting for the motor's speed"));
              }},
        Fault{"silent, and its driver has no words",
              [](DeviceStatus& status, Duration, Timestamp) { status.set(DeviceState::kStreaming); }},
        Fault{"another unit at each connect", [](DeviceStatus& status, Duration at, Timestamp) {
                if (at % 10s == 0s) status.identify("unit " + std::string(1, static_cast<char>('A' + at / 10s % 3)));
                status.set(DeviceState::kFault, problemOf("restarts"));
              }}));

TEST_F(Monitor, NamesWhatIsWrongAndWhatTheDeviceIs) {
  status.set(DeviceState::kStreaming);
  status.countSample(kNow);
  EXPECT_TRUE(monitor.problems(kNow).empty());
  EXPECT_EQ(monitor.identities(), "");
  status.identify("an A1");
  EXPECT_EQ(monitor.identities(), "; lidar is an A1");
  lidar_stuck = true;
  EXPECT_THAT(monitor.problems(kNow).at(0).text(), testing::StartsWith("lidar: every turn shows the same ranges"));
  const auto health = monitor.health(kNow + 250ms);
  ASSERT_EQ(health.size(), 1U);
  EXPECT_EQ(health[0].name, "lidar");
  EXPECT_EQ(health[0].samples, 1);
  EXPECT_NEAR(health[0].age, 0.25, 1e-9);
  EXPECT_EQ(health[0].expected, 10.0);
  EXPECT_THAT(health[0].reason, testing::HasSubstr("pull its plug"));
}

TEST_F(Monitor, CountsNoSampleOfBeforeItsBeginningForARate) {
  for (int i = 0; i < 50; ++i) status.countSample(kNow);
  monitor.begin();
  for (int i = 0; i < 10; ++i) status.countSample(kNow + 1s);
  monitor.measureRates(1.0, true, kNow + 1s);
  EXPECT_EQ(monitor.devices()[0].rate, 10.0);
}

}  // namespace
}  // namespace slam::device_monitor_test
