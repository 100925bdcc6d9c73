// SPDX-License-Identifier: BSD-3-Clause
// What the real-time threads do while every plug is pulled once: they neither allocate nor free nor open a file nor
// wait for a mutex nor for memory. Exceptions:
// - the lidar's thread connects, and ends a connection, at normal priority: that is not counted, but for page faults;
// - the depth thread is bound by none of this, since OpenNI2 is not;
// - a base or IMU that is there but does not answer is looked for at eight baud rates, once, by the base thread.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include "integration/live_faults.hpp"
#include "support/thread_work.hpp"

namespace slam::real_time_work_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Counts of one thread.
struct Work {
  std::uint64_t allocations = 0, frees = 0, opens = 0, waits = 0, faults = 0;
};

class RealTimeWork : public test::LiveFaults {
 protected:
  void SetUp() override {
    LiveFaults::SetUp();
    const std::string file = folder_ / "work";
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    ASSERT_EQ(ftruncate(descriptor, sizeof(test::WorkTable)), 0);
    void* const memory = mmap(nullptr, sizeof(test::WorkTable), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    close(descriptor);
    ASSERT_NE(memory, MAP_FAILED);
    table_ = static_cast<const test::WorkTable*>(memory);
    setenv("THREAD_WORK_FILE", file.c_str(), 1);
  }
  void TearDown() override {
    unsetenv("THREAD_WORK_FILE");
    LiveFaults::TearDown();
  }

  /// By the threads' names, since they began.
  std::map<std::string, Work> work() const {
    std::map<std::string, Work> all;
    for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(slamd_->id()) + "/task")) {
      std::string name, stat;
      std::ifstream(entry.path() / "comm") >> name;
      std::ifstream file(entry.path() / "stat");
      std::getline(file, stat);
      std::istringstream fields(stat.substr(stat.rfind(')') + 2));  // from the third one on
      std::string skipped;
      for (int field = 3; field < 10; ++field) fields >> skipped;
      std::uint64_t minor = 0, major = 0;
      fields >> minor >> skipped >> major;
      int policy = 0;
      for (int field = 13; field < 41; ++field) fields >> skipped;
      fields >> policy;
      if (policy != SCHED_FIFO) continue;  // another thread may have been begun by one of that name
      Work& work = all[name];
      work.faults = minor + major;
      for (std::size_t i = 0; i < table_->used && i < table_->threads.size(); ++i) {
        const test::ThreadWork& seen = table_->threads[i];
        if (seen.thread != std::stoi(entry.path().filename())) continue;
        work.allocations = seen.allocations;
        work.frees = seen.frees;
        work.opens = seen.opens;
        work.waits = seen.waits;
      }
    }
    return all;
  }

  const test::WorkTable* table_ = nullptr;
};

TEST_F(RealTimeWork, IsNoneThatWaitsWhileEveryPlugIsPulledOnce) {
  if (test::kSanitized) GTEST_SKIP() << "the sanitizers want to be loaded first";
  ASSERT_TRUE(listener_.good());
  startSimulator("300", "meeting-room", {"--speed", "0.2"});
  setenv("LD_PRELOAD", THREAD_WORK_LIBRARY ":" MODEM_LINES_LIBRARY, 1);
  setenv("MODEM_LINES", "", 1);
  startDaemon({"imu.driver='hfi'"});
  unsetenv("LD_PRELOAD");
  const auto isWellAll = [&] {
    return poseState() == kLocalised && isWell("lidar") && isWell("base") && isWell("imu") && isWell("depth");
  };
  ASSERT_TRUE(listener_.until(isWellAll, 30s)) << summary() << "\n" << daemonLog();
  if (summary().find("no SCHED_FIFO") != std::string::npos || daemonLog().find("no SCHED_FIFO") != std::string::npos)
    GTEST_SKIP() << "no right to real-time scheduling";
  worstStateFor(3s);
  const auto before = work();
  for (const auto& [device, status] :
       {std::pair("lidar", "lidar"), {"board", "base"}, {"imu", "imu"}, {"depth", "depth"}}) {
    inject(device, "unplug 1");
    EXPECT_TRUE(listener_.until([&] { return poseState(), !streams(status); }, 5s)) << device << ": " << summary();
    worstStateFor(4s);  // it is looked for several times
    inject(device, "unplug 0");
    EXPECT_TRUE(listener_.until([&] { return poseState(), streams(status); }, 10s)) << device << ": " << summary();
  }
  EXPECT_TRUE(listener_.until(isWellAll, 20s)) << summary();
  auto after = work();
  const bool locked = summary().find("locked") == std::string::npos;
  for (const char* name : {"base", "lidar", "estimator"}) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(before.contains(name));
    const Work& first = before.at(name);
    const Work& last = after[name];
    std::printf("%-10s %llu allocations, %llu frees, %llu opened files, %llu waits for a mutex, %llu page faults\n",
                name, static_cast<unsigned long long>(last.allocations - first.allocations),
                static_cast<unsigned long long>(last.frees - first.frees),
                static_cast<unsigned long long>(last.opens - first.opens),
                static_cast<unsigned long long>(last.waits - first.waits),
                static_cast<unsigned long long>(last.faults - first.faults));
    EXPECT_EQ(last.allocations, first.allocations);
    EXPECT_EQ(last.frees, first.frees);
    EXPECT_EQ(last.opens, first.opens);
    EXPECT_EQ(last.waits, first.waits);
    constexpr std::uint64_t kConnecting = 16;  // of the lidar's thread, at normal priority
    if (locked) {
      EXPECT_LE(last.faults - first.faults, name == std::string("lidar") ? kConnecting : 0U);
    }
  }
}

}  // namespace
}  // namespace slam::real_time_work_test
