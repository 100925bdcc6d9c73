// SPDX-License-Identifier: BSD-3-Clause
// Every device failing in every way, while slamd drives. The table in docs/fault-matrix.md is made of the same cells; a
// test compares the two, and writes the file anew where SLAMD_WRITE_DOCS is set.
#include "integration/fault_matrix.hpp"

#include <cmath>
#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "build_paths.hpp"
#include "drivers/can/can_base.hpp"
#include "drivers/can/fake_can_port.hpp"
#include "tools/sim/can/can_emulator.hpp"

namespace slam::fault_matrix_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::Cell;
using test::Row;

class FaultMatrix : public test::FaultMatrix {
 protected:
  void runRow(const Row& row) {
    ASSERT_TRUE(listener_.good());
    startSimulator("600", "meeting-room", {"--speed", "0.1"});            // slow: the drive must outlast the row
    if (!test::kSanitized) setenv("LD_PRELOAD", MODEM_LINES_LIBRARY, 1);  // the sanitizers want to be loaded first
    setenv("MODEM_LINES", "", 1);
    startDaemon({"imu.driver='hfi'"});
    unsetenv("LD_PRELOAD");
    run(row);
  }
};

TEST_F(FaultMatrix, Lidar) { runRow(rows()[0]); }
TEST_F(FaultMatrix, Depth) { runRow(rows()[1]); }
TEST_F(FaultMatrix, Board) { runRow(rows()[2]); }
TEST_F(FaultMatrix, Imu) { runRow(rows()[3]); }

/// Wheels and IMU on CAN: the emulator on one end of a bus, the driver on the other, in virtual time.
TEST(FaultMatrixCan, EachCell) {
  test::FakeCanBus bus;
  sim::CanEmulator emulator;
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
      for (const can::Frame& frame : frames) bus.put(frame);
      driver.tick();
    }
  };
  const auto inject = [&](const std::string& fault) {
    const auto space = fault.find(' ');
    return emulator.inject(fault.substr(0, space), std::stod(fault.substr(space)));
  };
  std::vector<std::pair<const DeviceStatus*, Cell>> cells;
  for (const Cell& cell : FaultMatrix::rows()[4].cells) cells.emplace_back(&driver.wheelStatus(), cell);
  for (const Cell& cell : FaultMatrix::rows()[5].cells) cells.emplace_back(&driver.imuStatus(), cell);
  for (const auto& [of, cell] : cells) {
    SCOPED_TRACE(cell.fault);
    const DeviceStatus& status = *of;
    runFor(3s);
    ASSERT_EQ(status.state.load(), DeviceState::kStreaming) << status.problem().words();
    ASSERT_EQ(status.problem().words(), "");
    const auto rejects = status.rejects.load();
    ASSERT_TRUE(inject(cell.inject));
    runFor(fromSeconds(std::max(1.0, cell.notice)));
    if (*cell.words != '\0') {
      EXPECT_THAT(status.problem().words(), testing::HasSubstr(cell.words)) << "in time";
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
    if (status.state == DeviceState::kStreaming) {
      EXPECT_GE(status.samples.load() - samples, 5) << "it streams, as it says";
    }
    ASSERT_TRUE(inject(cell.heal));
    runFor(1s);
    EXPECT_EQ(status.state.load(), DeviceState::kStreaming) << status.problem().words();
  }
}

std::string table() {
  std::ostringstream text;
  text
      << "# What slamd does when a device fails\n\n"
         "Made by `fault_matrix_test`, which breaks slam-sim's devices while slamd drives, and asserts each cell: the\n"
         "words in SLAM_HEALTH and when they come, the worst localisation state, how far from the truth a pose is\n"
         "that is called localised, that data flow again within three seconds and all is well. The rows of CAN are\n"
         "run by slamd in a virtual machine (`ctest -L vm`), and by its driver in virtual time. Those of network, "
         "clock\n"
         "and disk are read in the log, since no message comes without a network.\n\n"
         "| device | fault | SLAM_HEALTH says | pose meanwhile | what slamd does |\n|---|---|---|---|---|\n";
  const char* const states[] = {"", "localised", "localised or degraded", "localised, degraded or lost"};
  for (const Row& row : FaultMatrix::rows()) {
    for (const Cell& cell : row.cells) {
      std::ostringstream said;
      if (*cell.words != '\0') said << cell.notice << " s";
      text << "| " << row.device << " | " << cell.fault << " | "
           << (*cell.words == '\0' ? "nothing" : std::string("\"") + cell.words + "\" within ") << said.str() << " | "
           << states[cell.pose] << "; localised within " << cell.error << " m | " << cell.meaning << " |\n";
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
}  // namespace slam::fault_matrix_test
