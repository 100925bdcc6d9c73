// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/watchdog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::watchdog_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A base thread and a camera's, looked at each 100 ms.
class Watching : public testing::Test {
 protected:
  static constexpr Duration kPeriod = 100ms;
  enum { kBase, kCamera };
  Watching() : watchdog(kPeriod) {
    watchdog.add("base", {200ms, 10s});
    watchdog.add("camera", {.late = 200ms, .dead = 10s, .vital = false, .death = &problem::kCameraDead});
  }
  /// Time goes on. @param base, camera: the thread ticks meanwhile
  void goOn(Duration time, bool base = true, bool camera = true) {
    for (Duration gone{0}; gone < time; gone += kPeriod) {
      now += kPeriod;
      base_ticks += base ? 20 : 0;
      camera_ticks += camera ? 3 : 0;
      look();
    }
  }
  void look(Duration base_delay = Duration(0)) {
    watchdog.look(kBase, base_ticks, base_delay, base_starved, now);
    watchdog.look(kCamera, camera_ticks, Duration(0), Duration(0), now);
  }
  std::string news() {
    std::string text;
    for (const Watchdog::News& line : watchdog.takeNews(now))
      text += (line.is_error ? "error " : "") + line.problem.words() + "\n";
    return text;
  }

  std::string words() {
    std::string text;
    for (const Problem& problem : watchdog.problems(now)) text += problem.words() + "\n";
    return text;
  }

  Watchdog watchdog;
  Timestamp now{1000s};
  std::uint64_t base_ticks = 0, camera_ticks = 0;
  Duration base_starved{0};  // of each step
};

TEST_F(Watching, ReportsNothingOfThreadsThatTick) {
  goOn(60s);
  EXPECT_TRUE(watchdog.allAlive());
  EXPECT_TRUE(watchdog.problems(now).empty());
  EXPECT_EQ(news(), "");
}

TEST_F(Watching, TakesAThreadThatWaitsForTheKernelForLateNotForDead) {
  goOn(1s);
  for (int i = 0; i < 38; ++i) {
    goOn(kPeriod, /*base=*/false);
    EXPECT_TRUE(watchdog.allAlive()) << "a restart would end the pose and help nobody";
  }
  EXPECT_THAT(words(), AllOf(HasSubstr("thread base was late: 3"), HasSubstr("not for want of CPU"),
                             Not(HasSubstr("overloaded"))));
  EXPECT_EQ(news(), "") << "how late it is will be known when it ticks";
  goOn(kPeriod);
  EXPECT_THAT(news(), HasSubstr("thread base was late: 38"));
  EXPECT_THAT(words(), HasSubstr("thread base was late: 38"));
  goOn(31s);
  EXPECT_TRUE(watchdog.problems(now).empty());
}

TEST_F(Watching, TakesAThreadThatDoesNotComeBackForDead) {
  goOn(1s);
  goOn(9900ms, /*base=*/false);
  EXPECT_TRUE(watchdog.allAlive());
  goOn(300ms, /*base=*/false);
  EXPECT_FALSE(watchdog.allAlive());
  EXPECT_THAT(words(), HasSubstr("thread base does not tick; the watchdog is not fed"));
  EXPECT_THAT(news(), AllOf(HasSubstr("error "), HasSubstr("thread base does not tick")));
  goOn(60s, /*base=*/false);
  EXPECT_EQ(news(), "") << "once is enough";
  EXPECT_FALSE(watchdog.allAlive());
  goOn(kPeriod);
  EXPECT_TRUE(watchdog.allAlive());
}

TEST_F(Watching, TakesAThreadThatGetsNoCpuForStarvedHoweverLong) {
  goOn(1s);
  base_starved = 95ms;
  goOn(5s, /*base=*/false);
  EXPECT_TRUE(watchdog.isOverloaded(now));
  EXPECT_THAT(words(), AllOf(HasSubstr("the computer is overloaded: thread base has waited 4."),
                             HasSubstr("end other programs"), Not(HasSubstr("was late"))));
  EXPECT_THAT(news(), AllOf(HasSubstr("the computer is overloaded"), Not(HasSubstr("error "))));
  goOn(150s, /*base=*/false);
  EXPECT_TRUE(watchdog.allAlive()) << "it has had 8 s of its own";
  EXPECT_THAT(words(), Not(HasSubstr("does not tick")));
  base_starved = 0ms;
  goOn(5s, /*base=*/false);
  EXPECT_FALSE(watchdog.allAlive()) << "an overload keeps nobody from seeing that it hangs";
  EXPECT_THAT(news(), HasSubstr("error thread base does not tick"));
  goOn(31s);
  EXPECT_FALSE(watchdog.isOverloaded(now));
  EXPECT_TRUE(watchdog.problems(now).empty());
}

TEST_F(Watching, NamesOneCauseOfSeveralThatAreLate) {
  goOn(1s);
  base_starved = 80ms;
  goOn(3s, /*base=*/false, /*camera=*/false);  // the camera's waits for a lock of the base's
  EXPECT_THAT(words(), AllOf(HasSubstr("overloaded"), Not(HasSubstr("camera"))));
  base_starved = 0ms;
  goOn(1s);
  EXPECT_THAT(news(), AllOf(HasSubstr("overloaded"), Not(HasSubstr("camera"))));
  for (int i = 0; i < 100; ++i) goOn(500ms);
  base_starved = 40ms;  // less than half of the time
  goOn(60s);
  EXPECT_FALSE(watchdog.isOverloaded(now)) << "it ticks in time";
}

TEST_F(Watching, GoesOnWithoutAThreadThatIsNotVital) {
  goOn(20s, true, /*camera=*/false);
  EXPECT_TRUE(watchdog.allAlive());
  EXPECT_THAT(words(), HasSubstr("thread camera does not tick: its device is stuck"));
}

TEST_F(Watching, CountsNoSilenceWhileItDidNotLookItself) {
  goOn(1s);
  now += 60s;  // the whole process was stopped, and the threads have not been woken yet
  look();
  EXPECT_TRUE(watchdog.allAlive());
  EXPECT_EQ(words().find("60"), std::string::npos) << words();
  for (int i = 0; i < 10; ++i) {  // it is late itself each time
    now += 3s;
    base_ticks += 600;
    camera_ticks += 90;
    look();
  }
  now += 31s;
  EXPECT_TRUE(watchdog.problems(now).empty());
}

TEST_F(Watching, GetsADelayThatFellBetweenTwoReadings) {
  goOn(1s);
  now += kPeriod, ++base_ticks, ++camera_ticks;
  look(830ms);
  EXPECT_THAT(words(), HasSubstr("thread base was late: 830 ms"));
  EXPECT_THAT(news(), HasSubstr("thread base was late: 830 ms"));
  EXPECT_TRUE(watchdog.allAlive());
  now += kPeriod, ++base_ticks, ++camera_ticks;
  look(150ms);  // as it may be
  EXPECT_THAT(words(), HasSubstr("830 ms")) << "the worst one of half a minute";
}

TEST_F(Watching, LogsLatenessOnceAMinute) {
  goOn(1s);
  int lines = 0;
  for (int i = 0; i < 120; ++i) {  // two minutes
    goOn(500ms, /*base=*/false);
    goOn(500ms);
    lines += news().empty() ? 0 : 1;
  }
  EXPECT_EQ(lines, 2);
}

TEST_F(Watching, ExcusesAThreadThatHasReasonToBeSilent) {
  for (int i = 0; i < 50; ++i) {
    watchdog.excuse(kCamera);
    goOn(kPeriod, true, /*camera=*/false);
  }
  EXPECT_TRUE(watchdog.problems(now).empty());
  for (int i = 0; i < 60; ++i) {  // but not of being dead
    watchdog.excuse(kCamera);
    goOn(kPeriod, true, /*camera=*/false);
  }
  EXPECT_THAT(words(), HasSubstr("thread camera does not tick"));
}

}  // namespace
}  // namespace slam::watchdog_test
