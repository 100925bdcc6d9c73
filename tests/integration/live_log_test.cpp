// SPDX-License-Identifier: BSD-3-Clause
// The field log of a slamd that drives the emulated devices, and of one that is fed with a log.
#include <cmath>
#include <csignal>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <slam/health_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/scan_t.hpp>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "core/pose_history.hpp"
#include "integration/live.hpp"
#include "store/log_folder.hpp"
#include "tools/common/trajectory.hpp"

namespace slam::live_log_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::kBin;
using test::kConfig;
using test::kPatience;
using test::kSanitized;
using test::Listener;
using test::Process;
using testing::AllOf;
using testing::HasSubstr;

class LiveLog : public test::Live {
 protected:
  void startLogging(std::vector<std::string> further = {}) {
    further.insert(further.end(), {"log.directory='" + logs().string() + "'", "log.floor=1.0"});
    startDaemon(further);
  }
  fs::path logs() const { return folder_ / "logs"; }
  bool logsAre(std::size_t number) const { return fs::exists(logs()) && logFilesIn(logs()).size() >= number; }
  int run(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> command{kBin + "/" + program};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return Process(command, folder_ / "said.txt").wait(60s).value_or(-1);
  }
  int slamctl(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--config", kConfig, "--set", "log.directory='" + logs().string() + "'"});
    return run("slamctl", arguments);
  }
  std::string said() const { return textOf(folder_ / "said.txt"); }
  void endDaemon() {
    slamd_->signal(SIGTERM);
    EXPECT_EQ(slamd_->wait(10s), 0) << daemonLog();
  }
  static constexpr std::uint64_t kLargestEvent = 1 << 16;  // [bytes] above any scan
  /// @param torn [bytes] at most of the event that slamd is writing, or was when it was killed
  int scansIn(const fs::path& file, std::uint64_t torn = 0) const {
    EventLogReader reader(file);
    int scans = 0;
    for (LogEvent event; reader.next(event);) scans += event.channel == channel::kScan ? 1 : 0;
    EXPECT_LE(reader.skippedBytes(), torn) << file;
    return scans;
  }
};

TEST_F(LiveLog, ReplaysToTheLivePoses) {
  if (kSanitized) GTEST_SKIP() << "a slow slamd has other poses than a replay";
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("100", "meeting-room");
  startLogging({"log.file_length=5.0"});
  Trajectory live;
  const auto follow = [&] {
    const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
    if (pose && pose->state == 1 && (live.empty() || live.back().stamp < fromMicroseconds(pose->utime)))
      live.push_back({fromMicroseconds(pose->utime), {pose->x, pose->y, pose->theta}});
    return live.size() > 2000;
  };
  ASSERT_TRUE(listener.until(follow, 40s)) << daemonLog();
  endDaemon();
  EXPECT_GE(logFilesIn(logs()).size(), 4U);

  ASSERT_EQ(
      run("slam-replay", {"--log", logs(), "--causal", folder_ / "causal.tum", "--odometry", folder_ / "odom.tum"}), 0)
      << said();
  EXPECT_THAT(said(), HasSubstr("configuration of the log itself"));
  const Trajectory map = readTrajectory(folder_ / "causal.tum"), odometry = readTrajectory(folder_ / "odom.tum");
  ASSERT_EQ(map.size(), odometry.size());
  std::vector<double> distances, turns;
  for (std::size_t i = 0; i + 2 < map.size(); ++i) {
    // A scan is stamped with its first beam: half a turn after its last one it has been used, and the next one has not.
    const Timestamp stamp = map[i + 1].stamp + (map[i + 2].stamp - map[i + 1].stamp) / 2;
    // An overloaded computer uses scans and samples late, when they can no longer change the pose that was sent.
    if (map[i + 2].stamp - map[i].stamp > 500ms) continue;
    const auto lived = poseAt(live, stamp), moved = poseAt(odometry, stamp);
    if (!lived || !moved) continue;
    const Pose2 replayed = map[i].pose * between(odometry[i].pose, *moved);
    const Pose2 difference = between(*lived, replayed);
    distances.push_back(std::hypot(difference.x, difference.y));
    turns.push_back(std::abs(difference.theta));
  }
  ASSERT_GT(distances.size(), 60U);
  std::sort(distances.begin(), distances.end());
  std::sort(turns.begin(), turns.end());
  const std::size_t nearly_all = distances.size() * 95 / 100;
  EXPECT_LE(distances[nearly_all], 0.01) << "the largest is " << distances.back();
  EXPECT_LE(turns[nearly_all], 0.2 * M_PI / 180.0) << "the largest is " << turns.back();
  RecordProperty("distance_um", static_cast<int>(1e6 * distances.back()));
}

TEST_F(LiveLog, KeepsTheLogOfARunThatWasKilled) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("100");
  const std::string record = "output.record='" + (folder_ / "record.lcm").string() + "'";
  std::int64_t recorded = 0;
  for (std::size_t run = 1; run <= 2; ++run) {
    startLogging({record});
    const auto hasScans = [&] { return logsAre(run) && scansIn(logFilesIn(logs()).back().path, kLargestEvent) > 5; };
    ASSERT_TRUE(listener.until(hasScans, 20s)) << daemonLog();
    slamd_->signal(SIGKILL);
    slamd_->wait(5s);
    const auto size = static_cast<std::int64_t>(fs::file_size(folder_ / "record.lcm"));
    EXPECT_GT(size, recorded) << "the record grows from run to run";
    recorded = size;
  }
  const auto files = logFilesIn(logs());
  ASSERT_EQ(files.size(), 2U);
  EXPECT_NE(files[0].run(), files[1].run());
  for (const LogFile& file : files) EXPECT_GT(scansIn(file.path, kLargestEvent), 5) << file.path;
}

TEST_F(LiveLog, ObeysSlamctl) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("100");
  startLogging({"lcm.commands=true", "log.automatic=false", "log.content='all'"});
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kPose) > 20; }, 20s)) << daemonLog();
  EXPECT_FALSE(logsAre(1));
  EXPECT_EQ(slamctl({"log", "mark", "too early"}), 1);
  EXPECT_THAT(said(), HasSubstr("nothing is being logged"));
  EXPECT_EQ(slamctl({"log", "start"}), 0) << said();
  ASSERT_TRUE(listener.until([&] { return logsAre(1); }, 10s));
  EXPECT_EQ(slamctl({"log", "mark", "hit the wall"}), 0) << said();
  listener.listenFor(kPatience * 2s);
  EXPECT_EQ(slamctl({"status"}), 0);
  EXPECT_THAT(said(), AllOf(HasSubstr("log running:"), HasSubstr(" 0 lost")));
  EXPECT_EQ(slamctl({"log", "stop"}), 0) << said();
  EXPECT_EQ(slamctl({"status"}), 0);
  EXPECT_THAT(said(), HasSubstr("log not running"));
  slamd_->signal(SIGKILL);  // what follows needs no slamd
  slamd_->wait(5s);
  EXPECT_EQ(slamctl({"log", "list"}), 0);
  EXPECT_THAT(said(), AllOf(HasSubstr("0000.lcm"), HasSubstr("hit the wall"), HasSubstr("1 file in")));
  EXPECT_EQ(slamctl({"log", "export", "--since", "10min", "--out", folder_ / "all.lcm"}), 0) << said();
  EXPECT_GT(scansIn(folder_ / "all.lcm"), 5);
  EXPECT_EQ(run("slam-replay", {"--log", folder_ / "all.lcm", "--trajectory", folder_ / "all.tum"}), 0) << said();
  EXPECT_EQ(slamctl({"log", "export", "--since", "tomorrow", "--out", folder_ / "b.lcm"}), 1);
}

TEST_F(LiveLog, RecordsTheCamerasImages) {
  if (!test::kCamera) GTEST_SKIP() << "no camera in this build";
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("100", "meeting-room");
  startLogging({"log.images=true", "log.file_length=4.0"});
  const auto images = [&] {
    std::vector<LogFile> files = logsAre(1) ? logFilesIn(logs()) : std::vector<LogFile>{};
    std::erase_if(files, [](const LogFile& file) { return file.isLog(); });
    return files;
  };
  ASSERT_TRUE(listener.until([&] { return images().size() >= 3; }, kPatience * 30s)) << daemonLog();
  endDaemon();
  const std::vector<LogFile> all = images();
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    EXPECT_GT(all[i].bytes, 10'000U) << all[i].path;
    EXPECT_NE(all[i].number, all[i + 1].number);
  }
}

TEST_F(LiveLog, NamesTheAgeOfALogThatIsPlayed) {
  ASSERT_EQ(Process({kBin + "/slam-sim", "--scene", "tile-rectangle", "--seconds", "30", "--log", folder_ / "sim.lcm"},
                    folder_ / "sim.txt")
                .wait(30s),
            0);
  // Recorded ten minutes ago.
  const auto now =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch());
  {
    EventLogReader log(folder_ / "sim.lcm");
    EventLogWriter old(folder_ / "old.lcm");
    std::int64_t first = 0;
    for (LogEvent event; log.next(event);) {
      if (event.channel != channel::kScan) continue;
      auto scan = *decodeChecked<scan_t>(event.data);
      if (first == 0) first = scan.utime;
      scan.utime += now.count() - 600'000'000 - first;
      ASSERT_TRUE(old.writeMessage(scan.utime, channel::kScan, scan));
    }
  }
  Listener listener;
  ASSERT_TRUE(listener.good());
  startLogging({"lidar.driver='lcm'", "base.driver='none'", "imu.driver='none'", "depth.driver='none'"});
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kHealth) > 0; }, 10s)) << daemonLog();
  Process player({"lcm-logplayer", "--lcm-url=" + test::kUrl, folder_ / "old.lcm"}, folder_ / "player.txt");
  EXPECT_TRUE(listener.until(
      [&] {
        // What passes until the player has begun is part of the age.
        const std::string text = summary(listener);
        for (int age = 600; age < 640; ++age) {
          if (text.find("lidar: stamps are " + std::to_string(age) + " s old: use slam-replay") != std::string::npos)
            return true;
        }
        return false;
      },
      15s))
      << summary(listener) << daemonLog();
  // What came over LCM is in the log, as what slamd reads itself.
  ASSERT_TRUE(listener.until([&] { return logsAre(1); }, 10s));
  endDaemon();
  EXPECT_GT(scansIn(logFilesIn(logs()).at(0).path), 0);
}

}  // namespace
}  // namespace slam::live_log_test
