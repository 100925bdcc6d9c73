// SPDX-License-Identifier: BSD-3-Clause
// CAN and USB as no container has them: in a virtual machine of their own, with Debian's kernel.
#include <array>
#include <cmath>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "build_paths.hpp"
#include "runtime/clock.hpp"
#include "tools/sim/board/board_emulator.hpp"
#include "vm/machine.hpp"

namespace slam::vm_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::Machine;

const std::string kBin = SLAMD_BINARY_DIR;
const std::string kKernel = SLAMD_BINARY_DIR "/../vm";
const std::vector<std::string> kController = {"-object", "can-bus,id=bus",       "-device", "kvaser_pci,canbus=bus",
                                              "-device", "kvaser_pci,canbus=bus"};

/// The controller board's end of the serial line, with a robot that turns on the spot.
class Board {
 public:
  ~Board() { close(line_); }

  /// Answers what has come; waits a few milliseconds for it.
  void serve(const fs::path& socket) {
    if (line_ < 0) line_ = test::connectTo(socket);
    renew();
    pollfd waiting{line_, POLLIN, 0};
    std::array<std::uint8_t, 256> chunk;
    if (poll(&waiting, 1, 5) != 1) return;
    const ssize_t n = read(line_, chunk.data(), chunk.size());
    std::vector<std::uint8_t> out;
    if (n > 0) board_.receive({chunk.data(), static_cast<std::size_t>(n)}, out);
    if (!out.empty() && write(line_, out.data(), out.size()) < 0) return;
  }

 private:
  void renew() {
    const double t = toSeconds(monotonicNow() - start_);
    const auto noise = static_cast<float>(1e-3 * std::sin(1e3 * t));
    board_.renew(-t, t, {.online = 1, .gyro = {noise, 0.0F, 0.2F}, .accel = {noise, 0.0F, 9.81F}}, t);
  }

  Timestamp start_ = monotonicNow();
  sim::BoardEmulator board_;
  int line_ = -1;
};

class Vm : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        (std::string("vm_") + testing::UnitTest::GetInstance()->current_test_info()->name() + std::to_string(getpid()));
    fs::create_directories(folder_);
    test::Process prepare({SLAMD_SOURCE_DIR "/tests/vm/prepare_kernel", kKernel}, folder_ / "prepare.txt");
    const auto status = prepare.wait(200s);
    std::ifstream in(folder_ / "prepare.txt");
    std::ostringstream text;
    text << in.rdbuf();
    if (status == Machine::kSkipped) GTEST_SKIP() << text.str();
    ASSERT_EQ(status, 0) << text.str();
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(folder_);
  }
  void expectSuccess(const std::string& scenario, const std::vector<std::string>& devices) {
    Machine machine(folder_, kKernel, scenario,
                    {kBin + "/vm_guest_test", kBin + "/slam-sim", kBin + "/slamd", SLAMD_SOURCE_DIR "/config/sim.toml"},
                    devices, Machine::GuestTime::kInstructions);
    EXPECT_EQ(machine.exitStatus(250s), 0) << machine.report();
    expectTestsRan(machine);
  }

  /// A filter that matches nothing is a success to GoogleTest.
  static void expectTestsRan(const Machine& machine) {
    const std::string console = machine.console();
    EXPECT_NE(console.find("[  PASSED  ] "), std::string::npos) << machine.report();
    EXPECT_EQ(console.find("Running 0 tests"), std::string::npos) << machine.report();
  }

  fs::path folder_;
};

TEST_F(Vm, SocketCanStampsFiltersAndSurvivesAllThatHappensToAnInterface) { expectSuccess("vcan", {}); }

TEST_F(Vm, DriverWorksOnAControllerWithARealBitRate) { expectSuccess("kvaser", kController); }

TEST_F(Vm, SlamdNoticesAPulledUsbCableAndStreamsAgain) {
  const std::string plug = "usb-serial,id=ser0,bus=xhci.0,chardev=line,always-plugged=on";
  Machine machine(folder_, kKernel, "usb_serial",
                  {kBin + "/vm_guest_test", kBin + "/slamd", SLAMD_SOURCE_DIR "/tests/vm/guest/usb_serial.toml"},
                  {"-device", "qemu-xhci,id=xhci", "-chardev",
                   "socket,id=line,server=on,wait=off,path=" + (folder_ / "line").string(), "-device", plug},
                  Machine::GuestTime::kOfTheHost);
  Board board;
  const auto serve = [&] { board.serve(folder_ / "line"); };
  ASSERT_TRUE(machine.waitFor("base STREAMING", 100s, serve)) << machine.report();
  machine.forget();
  ASSERT_TRUE(machine.monitor("device_del ser0"));
  const auto noticed = machine.waitFor("base ABSENT", 10s, serve);
  ASSERT_TRUE(noticed) << machine.report();
  EXPECT_LT(*noticed, 1.0) << "[s]";
  RecordProperty("noticed_ms", static_cast<int>(*noticed * 1e3));
  // The emulated controller loses a plug that comes before the guest has done with the one that went.
  ASSERT_TRUE(machine.waitFor("no such port", 10s, serve)) << machine.report();
  machine.forget();
  ASSERT_TRUE(machine.monitor("device_add " + plug));
  EXPECT_TRUE(machine.waitFor("base STREAMING", 20s, serve)) << machine.report();
  EXPECT_EQ(machine.exitStatus(60s, serve), 0) << machine.report();
  expectTestsRan(machine);
}

}  // namespace
}  // namespace slam::vm_test
