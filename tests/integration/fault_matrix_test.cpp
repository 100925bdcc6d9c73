// SPDX-License-Identifier: BSD-3-Clause
// Every device failing in every way, while slamd drives: what it says, how well it goes on, and how it recovers. The
// table in docs/fault-matrix.md is made of the same cells; a test compares the two, and writes the file anew where
// SLAMD_WRITE_DOCS is set.
#include <cmath>
#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <slam/health_t.hpp>
#include <slam/pose_estimate_t.hpp>

#include "bus/channels.hpp"
#include "drivers/can_base.hpp"
#include "drivers/fake_can_port.hpp"
#include "integration/live.hpp"
#include "tools/sim/can_emulator.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::kPatience;

/// Localisation states by number in pose_estimate_t.
constexpr int kLocalised = 1, kDegraded = 2, kLost = 3;
constexpr int kStreaming = 2;
/// [1] of a core: slamd needs a tenth of it, a thread that spins all.
constexpr double kBusy = 0.7;

struct Cell {
  const char* fault;
  const char* inject;  ///< lines for slam-sim's fault pipe, after the device's name
  const char* heal;
  const char* words;     ///< that SLAM_HEALTH says of it; empty: nothing can be known of it
  int pose;              ///< worst localisation state that is right meanwhile
  const char* meaning;   ///< for the table: what slamd does
  double notice = 1.6;   ///< [s] that the words may take: a second, and the time they need to be heard
  int repeats = 0;       ///< how often it comes back
  double seconds = 2.5;  ///< that it lasts behind the words
  int at_least = 0;      ///< the localisation state that must be reached: 2, it must not be trusted silently
};
struct Row {
  const char* device;  ///< of slam-sim, and of the table
  const char* status;  ///< name of the device in SLAM_HEALTH
  std::vector<Cell> cells;
};

const std::vector<Row> kRows = {
#include "integration/fault_matrix.inc"
};

class FaultMatrix : public test::Live {
 protected:
  void inject(const std::string& device, const std::string& faults) const {
    std::istringstream lines(faults);
    std::ofstream pipe(folder_ / "devices" / "faults");
    for (std::string line; std::getline(lines, line, ';');) pipe << device << " " << line << std::endl;
  }
  std::optional<device_health_t> device(const std::string& name) {
    const auto health = listener_.last<health_t>(channel::kHealth);
    if (!health) return std::nullopt;
    for (const device_health_t& d : health->devices) {
      if (d.name == name) return d;
    }
    return std::nullopt;
  }
  std::string summary() {
    const auto health = listener_.last<health_t>(channel::kHealth);
    return health ? health->summary : "";
  }
  int pose() {
    const auto estimate = listener_.last<pose_estimate_t>(channel::kSlamPose);
    return estimate ? estimate->state : 0;
  }
  bool allIsWell(const char* status) {
    const auto d = device(status);
    return d && d->state == kStreaming && d->reason.empty() && pose() == kLocalised;
  }
  void run(const Row& row);

  test::Listener listener_;
};

void FaultMatrix::run(const Row& row) {
  ASSERT_TRUE(listener_.good());
  startSimulator("600", "meeting-room", "0.1");  // slow: the drive must outlast the row
  startDaemon({"imu.driver='hfi'"});
  for (const Cell& cell : row.cells) {
    SCOPED_TRACE(std::string(row.device) + " " + cell.fault);
    ASSERT_TRUE(listener_.until([&] { return allIsWell(row.status); }, kPatience * 20s)) << summary() << "\n"
                                                                                         << daemonLog();
    const auto rejects_before = device(row.status)->rejects;

    inject(row.device, cell.inject);
    const auto begin = test::Clock::now();
    const std::string words = cell.words;
    const bool said =
        words.empty() || listener_.until([&] { return summary().find(words) != std::string::npos; }, kPatience * 4s);
    const double noticed = std::chrono::duration<double>(test::Clock::now() - begin).count();
    EXPECT_TRUE(said) << summary();
    if (!test::kSanitized) {
      EXPECT_LT(noticed, cell.notice) << summary();
    }
    int worst = 0;
    listener_.until([&] { return worst = std::max(worst, pose()), false; },
                    std::chrono::milliseconds(static_cast<int>(1000 * cell.seconds)));
    EXPECT_GE(worst, cell.at_least) << summary();
    if (!test::kSanitized) {
      EXPECT_LT(listener_.last<health_t>(channel::kHealth)->cpu, kBusy) << "a thread spins";
    }
    for (int i = 0; i < cell.repeats; ++i) {  // on and off, and on again
      inject(row.device, cell.heal);
      listener_.listenFor(700ms);
      inject(row.device, cell.inject);
      listener_.until([&] { return worst = std::max(worst, pose()), false; }, 700ms);
    }
    EXPECT_LE(worst, cell.pose) << summary();
    EXPECT_EQ(simulatorLog().find("no fault"), std::string::npos) << simulatorLog();
    std::printf("%-6s %-12s noticed after %.1f s, pose state %d, rejected %lld: %s\n", row.device, cell.fault, noticed,
                worst, static_cast<long long>(device(row.status)->rejects - rejects_before), summary().c_str());

    inject(row.device, cell.heal);
    const auto healed = test::Clock::now();
    const auto streams = [&] {
      const auto d = device(row.status);
      return d->state == kStreaming && d->age >= 0.0 && d->age < 1.0;
    };
    EXPECT_TRUE(listener_.until(streams, kPatience * 5s)) << summary();
    if (!test::kSanitized) {
      EXPECT_LT(test::Clock::now() - healed, 3500ms) << "streams again, and says so";
    }
    const bool well = listener_.until([&] { return allIsWell(row.status); }, kPatience * 20s);
    std::printf("       well again after %.1f s\n", std::chrono::duration<double>(test::Clock::now() - healed).count());
    EXPECT_TRUE(well) << summary() << "\n" << daemonLog();
  }
}

TEST_F(FaultMatrix, Lidar) { run(kRows[0]); }
TEST_F(FaultMatrix, Depth) { run(kRows[1]); }
TEST_F(FaultMatrix, Board) { run(kRows[2]); }
TEST_F(FaultMatrix, Imu) { run(kRows[3]); }

/// Wheels and IMU on CAN: the emulator on one end of a bus, the driver on the other, in virtual time.
TEST(FaultMatrixCan, EachCell) {
  test::FakeCanBus bus;
  sim::CanEmulator emulator;
  int every = 1, count = 0;
  CanBase driver({}, test::FakeCanBus::now, {.wheels = [](const WheelAngles&) {}, .imu = [](const ImuSample&) {}},
                 std::make_unique<test::FakeCanPort>(bus));
  const auto runFor = [&](Duration time) {
    for (const Timestamp end = bus.clock + time; bus.clock < end;) {
      bus.clock += 5ms;
      const double t = toSeconds(bus.clock - test::FakeCanBus::kStart);
      const auto noise = static_cast<float>(0.05 * std::sin(1e3 * t));
      std::vector<can::Frame> frames;
      emulator.step(bus.clock, {.angles = {5.0 * t, 4.0 * t}, .gyro = {0, noise, 0.2F}, .accel = {0, 0, 9.75F}},
                    frames);
      const bool passes = ++count % every == 0;
      for (const can::Frame& frame : frames) {
        if (passes) bus.put(frame);
      }
      driver.tick();
    }
  };
  const auto inject = [&](const std::string& fault) {
    const auto space = fault.find(' ');
    const double value = std::stod(fault.substr(space));
    if (fault.substr(0, space) == "every") return every = static_cast<int>(value), true;
    return emulator.inject(fault.substr(0, space), value);
  };
  const DeviceStatus& status = driver.wheelStatus();
  for (const Cell& cell : kRows[4].cells) {
    SCOPED_TRACE(cell.fault);
    runFor(3s);
    ASSERT_EQ(status.state.load(), DeviceState::kStreaming) << status.reason.load();
    ASSERT_STREQ(status.reason, "");
    const auto rejects = status.rejects.load();
    ASSERT_TRUE(inject(cell.inject));
    runFor(1s);
    if (*cell.words != '\0') {
      EXPECT_THAT(status.reason.load(), testing::HasSubstr(cell.words)) << "within a second";
    }
    runFor(3s);
    const auto samples = status.samples.load();
    runFor(1s);
    if (std::string(cell.fault) == "garbage") {
      EXPECT_GT(status.rejects.load() - rejects, 200);
    }
    if (std::string(cell.fault) == "slow") {
      EXPECT_GT(status.samples.load() - samples, 10);
    }
    ASSERT_TRUE(inject(cell.heal));
    runFor(1s);
    EXPECT_EQ(status.state.load(), DeviceState::kStreaming) << status.reason.load();
  }
}

std::string table() {
  std::ostringstream text;
  text
      << "# What slamd does when a device fails\n\n"
         "Made by `fault_matrix_test`, which breaks slam-sim's devices while slamd drives, and asserts each cell: the\n"
         "words in SLAM_HEALTH, the worst localisation state, and that all is well again afterwards. On CAN the "
         "driver\n"
         "alone meets the emulator, in virtual time; with the kernel it is tested in a virtual machine (ctest -L "
         "vm).\n\n"
         "| device | fault | SLAM_HEALTH says | pose meanwhile | what slamd does |\n|---|---|---|---|---|\n";
  const char* const states[] = {"", "localised", "localised or degraded", "localised, degraded or lost"};
  for (const Row& row : kRows) {
    for (const Cell& cell : row.cells) {
      text << "| " << row.device << " | " << cell.fault << " | "
           << (*cell.words == '\0' ? "nothing" : std::string("\"") + cell.words + "\"") << " | "
           << (*row.status == '\0' ? "-" : states[cell.pose]) << " | " << cell.meaning << " |\n";
    }
  }
  return text.str();
}

TEST(FaultMatrixTable, IsTheOneInTheDocs) {
  const fs::path file = fs::path(SLAMD_SOURCE_DIR) / "docs" / "fault-matrix.md";
  if (std::getenv("SLAMD_WRITE_DOCS") != nullptr) std::ofstream(file) << table();
  std::ifstream in(file);
  const std::string written{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(written, table()) << "run with SLAMD_WRITE_DOCS=1, and read what has changed";
}

}  // namespace
}  // namespace slam
