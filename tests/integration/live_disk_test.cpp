// SPDX-License-Identifier: BSD-3-Clause
// What a computer may keep from slamd: disks, memory that may be locked, time.
#include <fcntl.h>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <slam/health_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <sys/mount.h>
#include <sys/stat.h>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "integration/live.hpp"
#include "store/map_store.hpp"

namespace slam::live_disk_test {
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
using testing::Not;

class LiveDisk : public test::Live {
 protected:
  static bool says(Listener& listener, const std::string& words) {
    return summary(listener).find(words) != std::string::npos;
  }
  bool drives(Listener& listener) {
    listener.forget();
    return listener.until([&] { return listener.count(channel::kPose) > 20; }, kPatience * 20s);
  }
  std::string storeAt(const fs::path& maps) const { return "store.directory='" + maps.string() + "'"; }
};

TEST_F(LiveDisk, RunsUnderAFiniteMemoryLimit) {
  if (kSanitized) GTEST_SKIP() << "the sanitizers' shadow memory cannot be locked";
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("100");
  for (const int mebibytes : {0, 8, 64, 96, 128, 160, 512}) {
    const std::string bytes = std::to_string(mebibytes << 20);
    const std::vector<std::string> limited = {"prlimit", "--memlock=" + bytes + ":" + bytes, "setpriv",
                                              "--bounding-set=-ipc_lock"};
    std::vector<std::string> trial = limited;
    trial.push_back("true");
    if (Process(trial, folder_ / "trial.txt").wait(5s) != 0) continue;  // no right to raise it
    listener.clear();
    startDaemon({}, limited);
    EXPECT_TRUE(drives(listener)) << mebibytes << " MiB: " << daemonLog();
    EXPECT_TRUE(listener.until([&] { return says(listener, "locked"); }, 5s)) << summary(listener);
    EXPECT_THAT(daemonLog(), AllOf(HasSubstr("may be locked"), HasSubstr("LimitMEMLOCK=infinity")));
    slamd_->signal(SIGTERM);
    EXPECT_EQ(slamd_->wait(5s), 0) << mebibytes << " MiB: " << daemonLog();
  }
}

TEST_F(LiveDisk, GivesAPoseWithoutADisk) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  const fs::path disk = folder_ / "disk";
  std::ofstream(disk) << "not mounted yet";
  startSimulator("100");
  startDaemon({storeAt(disk / "maps"), "output.record='" + (disk / "record.lcm").string() + "'"});
  ASSERT_TRUE(drives(listener)) << daemonLog();
  ASSERT_TRUE(listener.until([&] { return says(listener, "; map not written yet: "); }, 5s)) << summary(listener);
  EXPECT_THAT(summary(listener), AllOf(HasSubstr("the map is not stored"), HasSubstr("the record is not written")));
  Process status({kBin + "/slamctl", "--config", kConfig, "status"}, folder_ / "status.txt");
  EXPECT_EQ(status.wait(10s), 0);
  EXPECT_THAT(textOf(folder_ / "status.txt"), HasSubstr("the map is not stored"));

  fs::remove(disk);  // it is there
  EXPECT_TRUE(listener.until(
      [&] { return !says(listener, "the map is not stored") && !says(listener, "the record is not written"); }, 40s))
      << summary(listener);
  EXPECT_TRUE(listener.until([&] { return MapStore::newest(disk / "maps").has_value(); }, 20s)) << daemonLog();
  EXPECT_TRUE(drives(listener));
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(10s), 0) << daemonLog();
  EventLogReader record(disk / "record.lcm");
  int poses = 0;
  for (LogEvent event; record.next(event);) poses += event.channel == channel::kPose ? 1 : 0;
  EXPECT_GT(poses, 20);
}

TEST_F(LiveDisk, KeepsThePoseWhileTheDisksHang) {
  if (kSanitized) GTEST_SKIP() << "the sanitizers want to be loaded first";
  Listener listener;
  ASSERT_TRUE(listener.good());
  const std::string pipe = folder_ / "record", stuck = folder_ / "stuck";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);  // which never reads
  setenv("LD_PRELOAD", SLOW_DISK_LIBRARY, 1);
  setenv("SLOW_DISK_FILE", stuck.c_str(), 1);
  startSimulator("100", "meeting-room");
  startDaemon({storeAt(folder_ / "maps"), "output.record='" + pipe + "'", "store.journal_period=0.2",
               "log.directory='" + (folder_ / "logs").string() + "'", "log.floor=1.0"});
  unsetenv("LD_PRELOAD");
  unsetenv("SLOW_DISK_FILE");
  ASSERT_TRUE(drives(listener)) << daemonLog();
  ASSERT_TRUE(listener.until([&] { return MapStore::newest(folder_ / "maps").has_value(); }, 20s)) << daemonLog();

  std::ofstream(stuck) << "the disk hangs";
  ASSERT_TRUE(listener.until(
      [&] {
        return says(listener, "; map: the disk does not answer") && says(listener, "; record: the disk does not") &&
               says(listener, "; log: the disk does not");
      },
      40s))
      << summary(listener);
  const std::int64_t ticks = counterOf(listener, "graph.ticks");
  listener.forget();
  listener.listenFor(4s);
  EXPECT_GE(listener.count(channel::kPose), 4 * 60);
  EXPECT_GT(counterOf(listener, "graph.ticks"), ticks + 20) << "systemd's watchdog is fed";
  EXPECT_THAT(summary(listener), Not(HasSubstr("does not tick")));

  fs::remove(stuck);
  EXPECT_TRUE(
      listener.until([&] { return !says(listener, "; map: the disk") && !says(listener, "; log: the disk"); }, 20s))
      << summary(listener);
  EXPECT_EQ(counterOf(listener, "log.dropped"), 0) << "the queue holds as long as a disk usually hangs";
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(10s), 0) << daemonLog();  // although nobody ever read the record
  close(reader);
  EXPECT_THAT(daemonLog(), HasSubstr("the record's end is lost"));
  const auto map = MapStore::load(folder_ / "maps", *MapStore::newest(folder_ / "maps"), {});
  EXPECT_GE(map.state.keyframes.size(), counterOf(listener, "keyframes"));
}

TEST_F(LiveDisk, NamesAFullDiskAndWhatIsLost) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  const fs::path disk = folder_ / "disk", filler = disk / "filler";
  fs::create_directories(disk);
  if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=4m") != 0)
    GTEST_SKIP() << "no right to mount a disk of its own";
  const auto fill = [&] {
    std::ofstream file(filler, std::ios::app);
    while (file << std::string(4096, 'x') << std::flush) continue;
  };
  startSimulator("200", "meeting-room");
  startDaemon({storeAt(disk / "maps"), "store.journal_period=0.2"});
  ASSERT_TRUE(drives(listener)) << daemonLog();
  ASSERT_TRUE(listener.until([&] { return MapStore::newest(disk / "maps").has_value(); }, 20s)) << daemonLog();

  fill();
  ASSERT_TRUE(listener.until([&] { return says(listener, "; map not written since "); }, 40s)) << summary(listener);
  EXPECT_THAT(summary(listener), AllOf(HasSubstr(": no space on " + (disk / "maps").string()), HasSubstr("MB free)"),
                                       HasSubstr("slamd tries again; fix: make room")));
  Process status({kBin + "/slamctl", "--config", kConfig, "status"}, folder_ / "status.txt");
  EXPECT_EQ(status.wait(10s), 0);
  EXPECT_THAT(textOf(folder_ / "status.txt"), HasSubstr("map not written since "));
  EXPECT_THAT(daemonLog(), HasSubstr("error: map not written since "));

  fs::remove(filler);
  EXPECT_TRUE(listener.until([&] { return !says(listener, "map not written"); }, 40s)) << summary(listener);
  fill();
  ASSERT_TRUE(listener.until([&] { return says(listener, "keyframes are in memory alone"); }, 60s))
      << summary(listener);
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(20s), 1);
  EXPECT_THAT(daemonLog(), testing::ContainsRegex("the map is not stored: [0-9]+ of [0-9]+ keyframes are lost; map not "
                                                  "written since .*: no space on "));
  slamd_.reset();
  sim_.reset();
  umount2(disk.c_str(), MNT_DETACH);
}

TEST_F(LiveDisk, ReportsWhichThreadWasLate) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("60");
  startDaemon({});
  ASSERT_TRUE(drives(listener)) << daemonLog();
  slamd_->signal(SIGSTOP);
  listener.listenFor(1500ms);
  slamd_->signal(SIGCONT);
  // Each thread measures it at its own next tick.
  EXPECT_TRUE(listener.until(
      [&] { return says(listener, "thread base was late: 1") && says(listener, "thread estimator was late: 1"); }, 5s))
      << summary(listener);
  EXPECT_THAT(summary(listener), Not(HasSubstr("does not tick")));
  EXPECT_TRUE(drives(listener));
}

TEST_F(LiveDisk, WaitsForAMapToLocaliseIn) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("60");
  startDaemon({"mode='localise'", storeAt(folder_ / "maps"), "store.map='home'"});
  ASSERT_TRUE(listener.until([&] { return says(listener, "no map to localise in"); }, 15s)) << daemonLog();
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kScan) > 10; }, kPatience * 20s)) << daemonLog();
  const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->state, 0);
  EXPECT_EQ(listener.count(channel::kPose), 0);
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
}

}  // namespace
}  // namespace slam::live_disk_test
