// SPDX-License-Identifier: BSD-3-Clause
// CAN and USB as no container has them: in a virtual machine of their own, with Debian's kernel.
#include <array>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "runtime/clock.hpp"
#include "tools/sim/board_emulator.hpp"
#include "vm/machine.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::Machine;

const std::string kBin = SLAMD_BINARY_DIR;
const std::string kKernel = SLAMD_BINARY_DIR "/../vm";
const std::vector<std::string> kController = {"-object", "can-bus,id=bus",       "-device", "kvaser_pci,canbus=bus",
                                              "-device", "kvaser_pci,canbus=bus"};

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
    Machine machine(folder_, kKernel, scenario, {kBin + "/vm_guest_test"}, devices);
    EXPECT_EQ(machine.exitStatus(100s), 0) << machine.report();
    RecordProperty("console", machine.console());
  }

  fs::path folder_;
};

TEST_F(Vm, SocketCanStampsFiltersAndSurvivesAllThatHappensToAnInterface) { expectSuccess("vcan", {}); }

TEST_F(Vm, DriverWorksOnAControllerWithARealBitRate) { expectSuccess("kvaser", kController); }

}  // namespace
}  // namespace slam
