// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/ekf_timeline.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "support/allocations.hpp"

namespace slam::ekf_timeline_test {
namespace {

using namespace std::chrono_literals;

using std::chrono::milliseconds;
using AnySample = std::variant<PoseMeasurement, WheelSample, ImuSample>;

const EkfConfig kEkf;
const EkfTimelineConfig kTimeline;

Timestamp at(std::int64_t ms) { return Timestamp(milliseconds(1'000'000 + ms)); }
Timestamp stampOf(const AnySample& sample) {
  return std::visit([](const auto& s) { return s.stamp; }, sample);
}
UpdateResult add(EkfTimeline& timeline, const AnySample& sample) {
  return std::visit([&](const auto& s) { return timeline.add(s); }, sample);
}

WheelSample wheels(std::int64_t ms, const Pose2& pose) { return {.stamp = at(ms), .T_wheels_base = pose}; }
ImuSample imu(std::int64_t ms, double rate) { return {.stamp = at(ms), .gyro = {0, 0, rate}}; }
PoseMeasurement match(std::int64_t ms, const Pose2& pose, double sigma) {
  PoseMeasurement measurement{.stamp = at(ms), .T_map_base = pose};
  measurement.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  return measurement;
}

/// A noisy drive with changing speeds: wheels at 50 Hz, gyro at 100 Hz, matched scans at 10 Hz, in stamp order.
std::vector<AnySample> noisyDrive(int duration_ms, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<AnySample> samples;
  Pose2 truth, odometry{7, -3, 2};
  for (int ms = 0; ms <= duration_ms; ms += 10) {
    const double t = ms * 1e-3, speed = 0.4 + 0.2 * std::sin(t), rate = 0.8 * std::sin(0.7 * t);
    if (ms % 100 == 0)
      samples.emplace_back(
          match(ms, truth * Pose2{0.01 * normal(random), 0.01 * normal(random), 0.01 * normal(random)}, 0.01));
    if (ms % 20 == 0) samples.emplace_back(wheels(ms, odometry));
    samples.emplace_back(imu(ms, rate + 0.01 + 0.004 * normal(random)));
    const Eigen::Vector3d step = 0.01 * Eigen::Vector3d{speed, 0, rate};
    truth = truth * exp(step);
    odometry = odometry * exp(Eigen::Vector3d{step.x() * 1.01 + 1e-4 * normal(random), 0, step.z() * 0.98});
  }
  return samples;
}

/// The order in which samples arrive that are up to `delay` late.
std::vector<AnySample> delayed(const std::vector<AnySample>& samples, double delay, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> seconds(0.0, delay);
  std::vector<std::pair<Timestamp, AnySample>> arrivals;
  for (const AnySample& sample : samples) {
    const bool first = stampOf(sample) == stampOf(samples.front());  // the first to arrive begins the timeline
    arrivals.emplace_back(stampOf(sample) + fromSeconds(first ? 0.0 : seconds(random)), sample);
  }
  std::ranges::stable_sort(arrivals, {}, &std::pair<Timestamp, AnySample>::first);
  std::vector<AnySample> order;
  for (auto& [arrival, sample] : arrivals) order.push_back(sample);
  return order;
}

Ekf run(EkfTimeline& timeline, const std::vector<AnySample>& samples) {
  for (const AnySample& sample : samples) add(timeline, sample);
  return timeline.at(timeline.newestStamp());
}

void expectSame(const Pose2& actual, const Pose2& expected, double metres, double radians) {
  const Pose2 error = between(expected, actual);
  EXPECT_LT(error.translation().norm(), metres);
  EXPECT_LT(std::abs(error.theta), radians);
}

void expectSame(const Ekf& actual, const Ekf& expected) {
  EXPECT_EQ(actual.stamp(), expected.stamp());
  EXPECT_LT((actual.state() - expected.state()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((actual.covariance() - expected.covariance()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(actual.slip(), expected.slip());
  EXPECT_EQ(actual.standstill(), expected.standstill());
}

TEST(EkfTimeline, TakesNoWordOfTheWayFromASourceThatBeganAnew) {
  const auto driven = [](bool restarted) {
    EkfTimeline timeline({}, {});
    for (int i = 0; i <= 100; ++i) {
      // At 0.5 m/s; once the source begins anew, and says that it has not moved since the sample before.
      const double lost = i > 50 ? 0.01 : 0.0;
      timeline.add(WheelSample{.stamp = Timestamp(std::chrono::milliseconds(1000 + 20 * i)),
                               .T_wheels_base = {0.01 * i - lost, 0.0, 0.0},
                               .restarted = restarted && i == 51});
    }
    return timeline.at(Timestamp(std::chrono::milliseconds(3000)));
  };
  const Ekf told = driven(true), untold = driven(false);
  EXPECT_NEAR(told.pose().x, 1.0, 0.006);
  EXPECT_LT(untold.pose().x, 0.996);
}

TEST(EkfTimeline, StampsThatAreLateNowAndThenMakeNoSpeedThatHoldsWhenTheWheelsFallSilent) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> lateness(1.0 / 2.0);  // [ms]
    EkfTimeline timeline(kEkf, kTimeline);
    Timestamp stamp = at(-1);
    for (int i = 0; i <= 300; ++i) {  // 0.15 m/s, each 10 ms
      stamp = std::max(stamp + 100us, at(10 * i) + fromSeconds(1e-3 * lateness(random)));
      timeline.add(WheelSample{.stamp = stamp, .T_wheels_base = {0.0015 * i, 0.0, 0.0}});
      if (i < 10) continue;
      EXPECT_NEAR(timeline.at(stamp).twist().vx, 0.15, 0.16) << "seed " << seed << ", sample " << i;
      EXPECT_NEAR(timeline.at(stamp).pose().x, 0.0015 * i, 2e-3) << "all of the way";
      EXPECT_NEAR(timeline.at(stamp + 100ms).pose().x, 0.0015 * (i + 10), 0.017) << "silent since";
    }
  }
}

TEST(EkfTimeline, WheelsThatAreReadUnevenlyMakeNoSpeedThatHolds) {
  EkfTimeline timeline(kEkf, kTimeline);
  // 0.3 m/s, counted each 20 ms and asked for each 50 ms: every other reading is 10 ms old.
  for (int ms = 0; ms <= 3000; ms += 50) {
    const int counted = ms - ms % 20;
    timeline.add(wheels(ms, {0.0003 * counted, 0.0, 0.0}));
    if (ms < 200) continue;
    EXPECT_NEAR(timeline.at(at(ms)).twist().vx, 0.3, 0.03) << ms;
    EXPECT_NEAR(timeline.at(at(ms)).pose().x, 0.0003 * counted, 1e-4) << "all of the way, " << ms;
    EXPECT_NEAR(timeline.at(at(ms + 100)).pose().x, 0.0003 * (counted + 100), 0.002) << "and what comes, " << ms;
  }
}

TEST(EkfTimeline, ARobotThatStopsIsAcceptedAtOnce) {
  EkfTimeline timeline(kEkf, kTimeline);
  for (int ms = 0; ms <= 2000; ms += 20) {
    timeline.add(wheels(ms, {0.0003 * std::min(ms, 1000), 0.0, 0.0}));
    if (ms > 1000) {
      EXPECT_NEAR(timeline.at(at(ms + 100)).pose().x, 0.3, 1e-3) << ms;
    }
  }
}

/// Wheels and a gyro in deg/s, of which it is known from `known_from` on that it tells nothing.
EkfTimeline withWrongGyro(int known_from_ms, int until_ms) {
  EkfTimeline timeline(kEkf, kTimeline);
  for (int ms = 0; ms <= until_ms; ms += 10) {
    timeline.add(wheels(ms, {0.0, 0.0, 0.0004 * ms}));
    ImuSample sample = imu(ms, 23.0);
    sample.rate_known = ms < known_from_ms;
    timeline.add(sample);
  }
  return timeline;
}

TEST(EkfTimeline, AGyroWithoutInformationLeavesTheTurnToTheWheels) {
  EXPECT_NEAR(withWrongGyro(0, 2000).at(at(2000)).pose().theta, 0.8, 0.01);
  EXPECT_GT(std::abs(wrapAngle(withWrongGyro(3000, 2000).at(at(2000)).pose().theta - 0.8)), 0.1) << "believed";
}

TEST(EkfTimeline, AGyroThatWasWrongIsTakenBackAsFarAsItIsKept) {
  EkfTimeline timeline = withWrongGyro(3000, 800);
  ASSERT_GT(std::abs(wrapAngle(timeline.at(at(800)).pose().theta - 0.32)), 0.1);
  timeline.loseGyro();
  EXPECT_NEAR(timeline.at(at(800)).pose().theta, 0.32, 0.01);
  EXPECT_FALSE(timeline.at(at(800)).gyroActive());
  EXPECT_EQ(timeline.at(at(800)).counters().gyro_fused, 0U);
}

TEST(EkfTimeline, WheelsThatFellSilentAtRestDoNotHoldADrivingRobot) {
  EkfTimeline timeline(kEkf, kTimeline);
  for (int ms = 0; ms <= 6000; ms += 10) {
    const double x = 0.0003 * std::max(0, ms - 1500);  // 0.3 m/s, which no wheel tells
    if (ms <= 1500 && ms % 50 == 0) timeline.add(wheels(ms, {}));
    if (ms % 200 == 0) timeline.add(match(ms, {x, 0.0, 0.0}, 0.005));
    timeline.add(imu(ms, 0.01));
    EXPECT_NEAR(timeline.at(at(ms)).pose().x, x, ms < 3500 ? 0.1 : 0.02) << ms;
  }
}

TEST(EkfTimeline, ScansAreFollowedAtOnceWhereWheelsFallSilent) {
  for (const bool turns : {false, true}) {
    EkfTimeline timeline(kEkf, kTimeline);
    Pose2 pose;
    for (int ms = 0; ms <= 2000; ms += 10) {
      const bool moves = ms > 1000;  // and what the wheels know ends with 1000
      if (ms <= 1000) timeline.add(wheels(ms, {}));
      if (moves) pose = pose * exp(turns ? Eigen::Vector3d{0.0, 0.0, 0.008} : Eigen::Vector3d{0.004, 0.0, 0.0});
      if (ms % 180 == 0) timeline.add(match(ms, pose, 0.003));
    }
    EXPECT_EQ(timeline.at(at(2000)).counters().poses_rejected, 0U);
    const Pose2 error = between(pose, timeline.at(at(2000)).pose());
    EXPECT_LT(std::hypot(error.x, error.y), 0.02);
    EXPECT_LT(std::abs(error.theta), 0.02);
  }
}

TEST(EkfTimeline, WheelsThatComeBackLeaveThePoseThatScansHaveFollowed) {
  for (const bool gyro : {false, true}) {
    EkfTimeline timeline(kEkf, kTimeline);
    Pose2 pose;
    for (int ms = 0; ms <= 10000; ms += 10) {
      const double speed = ms / 1500 % 2 == 0 ? 0.4 : 0.0;  // [m/s] goes and stops
      pose = pose * exp(Eigen::Vector3d{0.01 * speed, 0.0, 0.01 * speed});
      const bool silent = ms > 1000 && ms < 8600;
      if (!silent && ms % 250 == 0) timeline.add(wheels(ms, pose));
      if (gyro) timeline.add(imu(ms, speed));
      if (ms % 180 == 0) timeline.add(match(ms, pose, 0.003));
      const Ekf ekf = timeline.at(at(ms));
      const double variance = std::max(ekf.covariance()(0, 0), ekf.covariance()(1, 1));
      if (ms > 2000) {
        EXPECT_LT(std::sqrt(variance), 0.5) << "[m] at " << ms << " ms";
      }
      if (ms > 8600) {
        EXPECT_LT((ekf.pose().translation() - pose.translation()).norm(), 0.08) << "at " << ms << " ms";
      }
    }
  }
}

TEST(EkfTimeline, WheelsThatComeBackGiveTheWayThatNothingElseDoes) {
  EkfTimeline timeline(kEkf, kTimeline);
  Pose2 pose;
  for (int ms = 0; ms <= 8000; ms += 10) {
    pose = pose * exp(Eigen::Vector3d{0.004, 0.0, 0.002});
    const bool silent = ms > 1000 && ms < 7500;
    if (!silent && ms % 50 == 0) timeline.add(wheels(ms, pose));
    if ((ms < 2000 || ms > 7500) && ms % 180 == 0) timeline.add(match(ms, pose, 0.003));
    if (ms < 7500) continue;
    const Ekf ekf = timeline.at(at(ms));
    EXPECT_LT((ekf.pose().translation() - pose.translation()).norm(), 0.05) << "at " << ms << " ms";
    EXPECT_LT(std::sqrt(std::max(ekf.covariance()(0, 0), ekf.covariance()(1, 1))), 0.5) << "[m] at " << ms << " ms";
  }
}

TEST(EkfTimeline, WheelsThatGiveNoTurnRestThoughTheirHeadingWanders) {
  EkfTimeline timeline(kEkf, kTimeline);
  for (int ms = 0; ms <= 1040; ms += 20) {
    WheelSample sample = wheels(ms, {0.0005 * std::min(ms, 1000), 0.0, 0.01 * (ms % 60)});
    sample.turn_rate_known = false;
    timeline.add(sample);
  }
  EXPECT_NEAR(timeline.at(at(1060)).twist().vx, 0.0, 0.01);
}

TEST(EkfTimeline, TheWayIsTheWheelsOwnHoweverUnevenTheirStamps) {
  // A board's answers that come late and then early make one interval's speed too low and the next one's too high:
  // neither says how fast the robot was in the interval before.
  for (const bool gyro : {true, false}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      std::mt19937 random(seed);
      std::uniform_int_distribution<int> late(0, 25);
      EkfTimeline timeline(kEkf, kTimeline);
      const double step = 0.015, turn = 0.01;  // [m], [rad] in 50 ms
      Pose2 odometry;
      int next_gyro = 0;
      for (int i = 0; i <= 200; ++i) {
        const int ms = 50 * i + (i % 2 == 0 ? 0 : late(random));
        for (; gyro && next_gyro <= ms; next_gyro += 20) timeline.add(imu(next_gyro, turn / 0.05));
        timeline.add(wheels(ms, odometry));
        odometry = odometry * exp({step, 0.0, turn});
      }
      const Pose2 error = between(exp({200 * step, 0.0, 200 * turn}), timeline.at(at(10'000)).pose());
      EXPECT_LT(std::hypot(error.x, error.y), 0.01) << seed;
      EXPECT_LT(std::abs(error.theta), 0.01) << seed;
    }
  }
}

TEST(EkfTimeline, SamplesInAnyOrderWithinTheWindowGiveTheResultOfTheRightOrder) {
  const auto sorted = noisyDrive(10'000);
  EkfTimeline reference(kEkf, kTimeline);
  const Ekf expected = run(reference, sorted);
  EXPECT_EQ(reference.lateFused(), 0U);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    EkfTimeline timeline(kEkf, kTimeline);
    expectSame(run(timeline, delayed(sorted, 0.8, seed)), expected);
    EXPECT_GT(timeline.lateFused(), 500U);
    EXPECT_EQ(timeline.tooOld(), 0U);
    EXPECT_EQ(timeline.newestStamp(), reference.newestStamp());
  }
}

TEST(EkfTimeline, UsesSamplesOfOneStampInTheSameOrderHoweverTheyArrive) {
  const auto before = noisyDrive(2000);
  std::vector<AnySample> together{match(2010, {0.9, 0.2, 0.3}, 0.3), wheels(2010, {8, -3, 2.4}), imu(2010, 0.7)};
  std::vector<int> order{0, 1, 2};
  EkfTimeline reference(kEkf, kTimeline);
  run(reference, before);
  const Ekf expected = run(reference, together);
  while (std::ranges::next_permutation(order).found) {
    EkfTimeline timeline(kEkf, kTimeline);
    run(timeline, before);
    for (const int i : order) add(timeline, together[static_cast<std::size_t>(i)]);
    expectSame(timeline.at(at(2010)), expected);
  }
}

TEST(EkfTimeline, CountsAndDropsWhatIsOlderThanTheWindow) {
  EkfTimeline timeline(kEkf, kTimeline);
  const Ekf before = run(timeline, noisyDrive(5000));
  EXPECT_EQ(timeline.add(match(3900, {50, 50, 1}, 0.01)), UpdateResult::kUseless);
  timeline.add(imu(3500, 3.0));
  timeline.add(wheels(0, {50, 50, 1}));
  EXPECT_EQ(timeline.tooOld(), 3U);
  EXPECT_EQ(timeline.lateFused(), 0U);
  expectSame(timeline.at(timeline.newestStamp()), before);

  EXPECT_NE(timeline.add(imu(4105, 0.0)), UpdateResult::kUseless);  // just within
  EXPECT_EQ(timeline.tooOld(), 3U);
  EXPECT_EQ(timeline.lateFused(), 1U);
}

TEST(EkfTimeline, FusesALateMatchAtItsOwnInstant) {
  const auto samples = noisyDrive(3000);
  std::vector<AnySample> without;
  for (const AnySample& sample : samples)
    if (!std::holds_alternative<PoseMeasurement>(sample)) without.push_back(sample);
  EkfTimeline timeline(kEkf, kTimeline);
  run(timeline, without);
  const Pose2 then = timeline.at(at(2500)).pose(), now = timeline.at(at(3000)).pose();
  const Pose2 measured = then * Pose2{0.02, -0.03, 0.02};

  ASSERT_EQ(timeline.add(match(2500, measured, 1e-5)), UpdateResult::kFused);

  expectSame(timeline.at(at(2500)).pose(), measured, 1e-4, 1e-4);
  expectSame(timeline.at(at(3000)).pose(), measured * between(then, now), 1e-2, 1e-2);
}

TEST(EkfTimeline, WheelsAloneDeadReckonLikeTheWheelsThemselves) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  EkfTimeline timeline(kEkf, kTimeline);
  Pose2 odometry{7, -3, 2};
  std::vector<Pose2> poses;
  double speed = 0.0, rate = 0.0;
  for (int ms = 0; ms <= 20'000; ms += 20) {
    timeline.add(wheels(ms, odometry));
    poses.push_back(odometry);
    speed += 0.02 * normal(random) - 0.02 * (speed - 0.3);
    rate += 0.05 * normal(random) - 0.02 * rate;
    odometry = odometry * exp(0.02 * Eigen::Vector3d{speed, 0, rate});
  }
  const Pose2 start = timeline.at(timeline.oldestStamp()).pose();
  const Pose2 begin = poses[static_cast<std::size_t>((timeline.oldestStamp() - at(0)) / milliseconds(20))];
  expectSame(between(start, timeline.at(at(20'000)).pose()), between(begin, poses.back()), 2e-3, 5e-3);  // of 0.3 m
  expectSame(timeline.at(at(20'000)).pose(), between(poses.front(), poses.back()), 0.05, 0.02);          // of 6 m
}

TEST(EkfTimeline, ConstantWheelSpeedsAreDeadReckonedExactlyAlsoWithSamplesLost) {
  std::mt19937 random(3);
  const Eigen::Vector3d twist{0.4, 0, 0.9};
  EkfTimeline timeline(kEkf, kTimeline);
  for (int ms = 0; ms <= 10'000; ms += 20)
    if (ms % 1000 == 0 || random() % 3 != 0) timeline.add(wheels(ms, exp(twist * ms * 1e-3)));
  // Once the speeds have settled, an interval is an arc of these speeds.
  expectSame(between(timeline.at(at(9100)).pose(), timeline.at(at(10'000)).pose()), exp(0.9 * twist), 1e-6, 1e-6);
}

TEST(EkfTimeline, WheelsThatReportSeldomGiveTheWholeWay) {
  EkfTimeline timeline(kEkf, kTimeline);
  for (int i = 0; i <= 20; ++i) timeline.add(wheels(2000 * i, {0.8 * i, 0.0, 0.0}));
  EXPECT_NEAR(timeline.at(at(40'000)).pose().x, 16.0, 0.05);
  EXPECT_NEAR(timeline.at(at(39'000)).pose().x, 15.6, 0.05);
}

TEST(EkfTimeline, BeginsAtThePoseThatIsGiven) {
  EkfConfig config;
  config.initial_pose = {3.0, -2.0, 1.5};
  EkfTimeline timeline(config, kTimeline);
  timeline.add(wheels(0, {7.0, 7.0, 0.0}));
  EXPECT_EQ(timeline.at(at(0)).pose(), config.initial_pose);
}

TEST(EkfTimeline, AShortCapacityChangesNothingForSamplesInOrder) {
  const auto samples = noisyDrive(5000);
  EkfTimeline large(kEkf, kTimeline), small(kEkf, {.window = 1.0, .capacity = 32});
  expectSame(run(small, samples), run(large, samples));
}

TEST(EkfTimeline, ResultsAreOfTheInstantThatIsAskedFor) {
  EkfTimeline timeline(kEkf, kTimeline);
  EXPECT_FALSE(timeline.started());
  run(timeline, noisyDrive(3000));
  EXPECT_TRUE(timeline.started());
  EXPECT_EQ(timeline.newestStamp(), at(3000));
  EXPECT_EQ(timeline.at(at(2503)).stamp(), at(2503));
  EXPECT_EQ(timeline.at(at(3050)).stamp(), at(3050));
  EXPECT_EQ(timeline.at(at(0)).stamp(), timeline.oldestStamp());
  EXPECT_LE(timeline.oldestStamp(), at(2000));
}

TEST(EkfTimeline, ABiasFromElsewhereHoldsFromThenOnThoughSamplesComeLate) {
  EkfTimeline timeline(kEkf, kTimeline);
  timeline.add(GyroBias{0.3, 1e-6});  // nothing is known to begin with: it is not used
  for (int ms = 0; ms <= 500; ms += 10) timeline.add(imu(ms, 0.02));
  EXPECT_LT(timeline.at(at(500)).gyroBias(), 0.1);
  const double before = timeline.at(at(500)).pose().theta;
  timeline.add(GyroBias{0.02, 1e-6});
  EXPECT_EQ(timeline.newestStamp(), at(500));
  timeline.add(wheels(480, {}));  // late: the filter is run again from there
  for (int ms = 510; ms <= 1500; ms += 10) timeline.add(imu(ms, 0.02));
  EXPECT_NEAR(timeline.at(at(1500)).gyroBias(), 0.02, 1e-12);
  EXPECT_NEAR(timeline.at(at(1500)).pose().theta, before, 1e-3);
}

TEST(EkfTimeline, DoesNotCoastForever) {
  EkfTimeline timeline(kEkf, kTimeline);
  for (int ms = 0; ms <= 3000; ms += 20) timeline.add(wheels(ms, {ms * 1e-3, 0, 0}));
  const Pose2 newest = timeline.at(at(3000)).pose();
  EXPECT_NEAR(between(newest, timeline.at(at(3200)).pose()).x, 0.2, 0.01);
  EXPECT_NEAR(between(newest, timeline.at(at(60'000)).pose()).x, kEkf.max_coast, 0.01);
}

TEST(EkfTimeline, PredictsAPoseToTheSameBitsWithoutItsCovariance) {
  for (const bool smooth : {false, true}) {
    EkfConfig config = kEkf;
    config.smooth = smooth;
    EkfTimeline timeline(config, kTimeline);
    run(timeline, noisyDrive(3000));
    for (int ms = 1900; ms <= 8000; ms += 7)
      EXPECT_EQ(timeline.poseAt(at(ms)), timeline.at(at(ms)).pose()) << ms << (smooth ? " ms, smooth" : " ms");
    EXPECT_EQ(timeline.newest().state(), timeline.at(timeline.newestStamp()).state());
  }
}

TEST(EkfTimeline, HistoryHoldsBothEndsAndEachSampleBetween) {
  EkfTimeline timeline(kEkf, kTimeline);
  run(timeline, noisyDrive(3000));
  PoseHistory history(512);
  timeline.fillHistory(at(2495), at(2605), history);
  ASSERT_EQ(history.size(), 13U);
  EXPECT_EQ(history[0].stamp, at(2495));
  EXPECT_EQ(history.newest().stamp, at(2605));
  for (std::size_t i = 0; i < history.size(); ++i) {
    if (i > 0 && i < 12) {
      EXPECT_EQ(history[i].stamp, at(2490 + 10 * static_cast<int>(i)));
    }
    expectSame(history[i].pose, timeline.at(history[i].stamp).pose(), 1e-12, 1e-12);
  }
}

TEST(EkfTimeline, SetPoseGoesOnFromThereWithItsBias) {
  EkfTimeline timeline(kEkf, kTimeline);
  const Ekf before = run(timeline, noisyDrive(3000));
  timeline.setPose({10, 20, 1}, {0.1, 0.1, 0.1});
  EXPECT_EQ(timeline.newestStamp(), at(3000));
  Ekf now = timeline.at(at(3000));
  expectSame(now.pose(), {10, 20, 1}, 1e-12, 1e-12);
  EXPECT_EQ(now.gyroBias(), before.gyroBias());
  EXPECT_NEAR(now.covariance()(Ekf::kGyroBias, Ekf::kGyroBias), before.covariance()(Ekf::kGyroBias, Ekf::kGyroBias),
              1e-15);

  timeline.add(match(2900, {0, 0, 0}, 0.01));  // of before the command
  expectSame(timeline.at(at(3000)).pose(), {10, 20, 1}, 1e-12, 1e-12);

  Pose2 odometry{-5, 4, 0};
  for (int ms = 3020; ms <= 8020; ms += 20) {
    timeline.add(wheels(ms, odometry));
    timeline.add(imu(ms, before.gyroBias()));
    odometry = odometry * Pose2{0.01, 0, 0};
  }
  const Pose2 moved = between({10, 20, 1}, timeline.at(at(8020)).pose());
  EXPECT_NEAR(moved.x, 2.5, 0.05);
  EXPECT_NEAR(moved.y, 0.0, 0.05);
}

TEST(EkfTimeline, StaysFiniteUnderBrokenAndRepeatedSamples) {
  constexpr double kBroken[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                                1e300};
  std::mt19937 random(4);
  EkfTimeline timeline(kEkf, kTimeline);
  for (const AnySample& sample : delayed(noisyDrive(10'000), 0.3, 1)) {
    add(timeline, sample);
    if (random() % 5 == 0) add(timeline, sample);
    if (random() % 5 == 0) {
      const double broken = kBroken[random() % 3];
      const std::int64_t ms = (stampOf(sample) - at(0)) / milliseconds(1);
      switch (random() % 3) {
        case 0:
          timeline.add(imu(ms, broken));
          break;
        case 1:
          timeline.add(wheels(ms, {broken, 0, 0}));
          break;
        default:
          timeline.add(match(ms, {0, broken, 0}, 0.01));
      }
    }
    const Ekf newest = timeline.at(timeline.newestStamp());
    ASSERT_TRUE(newest.state().allFinite());
    ASSERT_TRUE(newest.covariance().allFinite());
  }
  EkfTimeline clean(kEkf, kTimeline);
  expectSame(timeline.at(at(10'000)).pose(), run(clean, noisyDrive(10'000)).pose(), 0.05, 0.05);
}

TEST(EkfTimeline, DoesNotAllocateAfterConstruction) {
  const auto samples = delayed(noisyDrive(5000), 0.5, 1);
  EkfTimeline timeline(kEkf, {.window = 1.0, .capacity = 128});
  PoseHistory history(64);
  EXPECT_EQ(test::allocationsDuring([&] {
              run(timeline, samples);
              timeline.fillHistory(at(4500), at(5000), history);
              timeline.setPose({1, 2, 3}, {0.1, 0.1, 0.1});
              run(timeline, samples);
            }),
            0U);
}

TEST(EkfTimeline, LearnsTheGyroBiasAtStandstillWhenGyroAndWheelsNeverComeTogether) {
  // The board's answers interleave: no gyro sample has the stamp of a wheel sample.
  EkfTimeline timeline({}, {});
  const Timestamp start{100s};
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.0015);
  for (int i = 0; i < 100; ++i) {
    timeline.add(ImuSample{start + i * 20ms + 7ms, {0, 0, -0.0118 + noise(random)}, {0, 0, 9.81}});
    if (i % 4 == 0) timeline.add(WheelSample{start + i * 20ms, {}});
  }
  EXPECT_NEAR(timeline.at(timeline.newestStamp()).gyroBias(), -0.0118, 0.001);
}

}  // namespace
}  // namespace slam::ekf_timeline_test
