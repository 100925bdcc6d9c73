// SPDX-License-Identifier: BSD-3-Clause
// The rows of the fault matrix that are no device's: network, clock and disk, while slamd drives.
#include <atomic>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <unistd.h>

#include "bus/channels.hpp"
#include "integration/fault_matrix.hpp"
#include "store/map_store.hpp"
#include "support/network.hpp"

namespace slam::fault_matrix_system_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::Cell;
using test::Clock;
using test::Row;

class FaultMatrixSystem : public test::FaultMatrix {
 protected:
  void SetUp() override {
    LiveFaults::SetUp();
    const std::string file = folder_ / "clock";
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    ASSERT_EQ(ftruncate(descriptor, sizeof *clock_), 0);
    void* const memory = mmap(nullptr, sizeof *clock_, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    close(descriptor);
    ASSERT_NE(memory, MAP_FAILED);
    clock_ = static_cast<std::atomic<std::int64_t>*>(memory);
    setenv("CLOCK_OFFSET_FILE", file.c_str(), 1);
    setenv("SLOW_DISK_FILE", (folder_ / "hangs").c_str(), 1);
    setenv("READ_ONLY_DISK_FILE", (folder_ / "read_only").c_str(), 1);
    fs::create_directories(disk_ = folder_ / "disk");
  }
  bool mountDisk() const {
    return unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
           mount("tmpfs", disk_.c_str(), "tmpfs", 0, "size=4m") == 0;
  }

  /// @return false for an unknown fault
  bool injectHere(const std::string& device, const std::string& fault) {
    const auto space = fault.find(' ');
    const std::string kind = device + " " + fault.substr(0, space);
    const std::int64_t value = std::stoll(fault.substr(space));
    const auto mark = [&](const char* file) {
      value != 0 ? void(std::ofstream(folder_ / file) << "yes") : void(fs::remove(folder_ / file));
      return true;
    };
    if (kind == "network no_route")
      return test::shell(value != 0 ? "ip route del 224.0.0.0/4" : "ip route add 224.0.0.0/4 dev lo");
    if (kind == "network rival") return rival_ = value != 0, true;
    if (kind == "clock set") return *clock_ += value, true;
    if (kind == "disk hang") return mark("hangs");
    if (kind == "disk read_only") return mark("read_only");
    const fs::path maps = disk_ / "maps", away = disk_ / "away", filler = disk_ / "filler";
    if (kind == "disk full" && value == 0) return fs::remove(filler);
    if (kind == "disk full") {
      std::ofstream file(filler);
      while (file << std::string(4096, 'x') << std::flush) continue;
      return true;
    }
    if (kind != "disk gone") return false;
    if (value == 0) fs::remove(maps);
    fs::rename(value != 0 ? maps : away, value != 0 ? away : maps);
    if (value != 0) std::ofstream(maps) << "not mounted";
    return true;
  }
  /// Listens, and publishes another's pose where that is the fault.
  template <typename Condition>
  bool liveUntil(Condition&& condition, Clock::duration limit) {
    auto next = Clock::now();
    for (const auto end = Clock::now() + limit; !condition();) {
      if (Clock::now() > end) return false;
      worst_ = std::max(worst_, poseState());
      listener_.listenOnce(50);
      const auto pose = listener_.last<pose_estimate_t>(channel::kSlamPose);
      if (!rival_ || !pose || Clock::now() < next) continue;
      next = Clock::now() + 100ms;
      auto other = *pose;
      other.x += 0.001 * static_cast<double>(++published_);
      other.state = kLocalised;
      listener_.lcm().publish(channel::kSlamPose, &other);
    }
    return true;
  }
  /// What the log has gained since a length of it.
  std::string logSince(std::size_t length) const { return daemonLog().substr(length); }

  void runHere(const Row& row, const Cell& cell) {
    SCOPED_TRACE(std::string(row.device) + " " + cell.fault);
    ASSERT_TRUE(liveUntil([&] { return poseState() == kLocalised; }, 20s)) << summary() << "\n" << daemonLog();
    const std::size_t before = daemonLog().size();
    worst_ = 0;
    const auto begin = Clock::now();
    ASSERT_TRUE(injectHere(row.device, cell.inject));
    const auto seconds = [](double time) { return std::chrono::milliseconds(static_cast<int>(1e3 * time)); };
    std::string line;
    const bool said = liveUntil(
        [&] {
          const std::string log = logSince(before);
          const auto at = log.find(cell.words);
          if (at == std::string::npos) return false;
          const auto first = log.rfind('\n', at) + 1;
          line = log.substr(first, log.find('\n', at) - first);
          return log.find('\n', at) != std::string::npos;
        },
        seconds(cell.notice));
    const double noticed = std::chrono::duration<double>(Clock::now() - begin).count();
    EXPECT_TRUE(said) << summary() << "\n" << logSince(before);
    EXPECT_THAT(line, testing::ContainsRegex(test::kConsequence));
    EXPECT_THAT(line, testing::ContainsRegex(test::kFix));
    liveUntil([] { return false; }, seconds(cell.seconds));
    std::printf("%-7s %-14s noticed after %.1f s, pose state %d: %s\n", row.device, cell.fault, noticed, worst_,
                line.c_str());
    EXPECT_LE(worst_, cell.pose) << summary();
    if (*cell.heal == '\0') return;
    const std::size_t ill = daemonLog().size();
    ASSERT_TRUE(injectHere(row.device, cell.heal));
    EXPECT_TRUE(liveUntil([&] { return logSince(ill).find(cell.recovery) != std::string::npos; }, 45s))
        << cell.recovery << "\n"
        << summary() << "\n"
        << logSince(ill);
  }

  fs::path disk_;
  std::atomic<std::int64_t>* clock_ = nullptr;  // [s] that it was set by
  bool rival_ = false;
  int worst_ = 0, published_ = 0;
};

TEST_F(FaultMatrixSystem, EachCell) {
  if (test::kSanitized) GTEST_SKIP() << "the sanitizers want to be loaded first";
  if (!mountDisk()) GTEST_SKIP() << "no right to mount a disk of its own";
  ASSERT_TRUE(listener_.good());
  startSimulator("600", "meeting-room", {"--speed", "0.1"});
  setenv("LD_PRELOAD", FAULTY_SYSTEM_LIBRARIES, 1);
  startDaemon({"store.directory='" + (disk_ / "maps").string() + "'", "store.journal_period=0.2"});
  unsetenv("LD_PRELOAD");
  ASSERT_TRUE(listener_.until([&] { return MapStore::newest(disk_ / "maps").has_value(); }, 40s)) << daemonLog();
  for (const Row& row : rows()) {
    if (std::string(row.status) != "system") continue;
    for (const Cell& cell : row.cells) ASSERT_NO_FATAL_FAILURE(runHere(row, cell));
  }
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(20s), 0) << daemonLog();
  slamd_.reset();
  sim_.reset();
  umount2(disk_.c_str(), MNT_DETACH);
}

}  // namespace
}  // namespace slam::fault_matrix_system_test
