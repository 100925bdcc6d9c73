// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/doctor.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <grp.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/local_socket.hpp"
#include "drivers/camera/fake_usb.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using test::FakeUsb;
using testing::HasSubstr;

class Doctor : public testing::Test {
 protected:
  Doctor() { fs::create_directories(directory_); }
  ~Doctor() override { fs::remove_all(directory_); }
  void canInterface(const char* flags, const char* queue) {
    fs::create_directories(directory_ / "can0");
    std::ofstream(directory_ / "can0" / "flags") << flags << "\n";
    std::ofstream(directory_ / "can0" / "tx_queue_len") << queue << "\n";
  }
  const fs::path directory_ = fs::path(testing::TempDir()) / ("doctor_" + std::to_string(getpid()));
};

TEST_F(Doctor, NamesThePortsToChooseFromWhereOneIsMissing) {
  const Finding finding = checkPort("lidar", directory_ / "none", "lidar.port",
                                    {{"/dev/ttyUSB0", "10c4:ea60 CP2102 0001"}, {"/dev/ttyS0", ""}});
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.what, HasSubstr("none"));
  EXPECT_THAT(finding.fix, testing::AllOf(HasSubstr("/dev/ttyUSB0 (10c4:ea60 CP2102 0001)"), HasSubstr("lidar.port")));
  EXPECT_THAT(checkPort("lidar", directory_ / "none", "lidar.port", {}).fix, HasSubstr("no serial port"));
}

TEST_F(Doctor, TellsAPortFromOneWithoutRights) {
  const fs::path port = directory_ / "port";
  std::ofstream(port) << "";
  EXPECT_EQ(checkPort("lidar", port, "lidar.port", {}).level, Finding::kGood);
  if (geteuid() == 0) return;  // root may open anything
  fs::permissions(port, fs::perms::none);
  const Finding finding = checkPort("lidar", port, "lidar.port", {});
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.fix, HasSubstr("usermod -aG dialout"));
}

TEST_F(Doctor, TellsAnAbsentCameraFromAForbiddenOne) {
  FakeUsb usb;
  EXPECT_EQ(checkCamera(usb).level, Finding::kGood);
  usb.may_open = false;
  EXPECT_THAT(checkCamera(usb).what, HasSubstr("no right"));
  usb.on_bus = false;
  EXPECT_THAT(checkCamera(usb).what, HasSubstr("no PrimeSense camera"));
}

TEST_F(Doctor, AsksForTheCamerasHeight) {
  DepthDeviceConfig depth;
  EXPECT_EQ(checkMounting(depth).level, Finding::kFault);
  EXPECT_THAT(checkMounting(depth).fix, HasSubstr("depth.z"));
  depth.projection.extrinsics.z = 0.3;
  EXPECT_EQ(checkMounting(depth).level, Finding::kGood);
}

TEST_F(Doctor, KnowsACanInterfaceThatIsGoneDownOrShortOfRoom) {
  EXPECT_THAT(checkCan("can0", directory_).what, HasSubstr("no interface can0"));
  canInterface("0x40080", "256");
  EXPECT_THAT(checkCan("can0", directory_).what, HasSubstr("is down"));
  EXPECT_THAT(checkCan("can0", directory_).fix, HasSubstr("ip link set can0 up"));
  canInterface("0x40081", "10");
  EXPECT_EQ(checkCan("can0", directory_).level, Finding::kWarning);
  canInterface("0x40081", "256");
  EXPECT_EQ(checkCan("can0", directory_).level, Finding::kGood);
}

TEST_F(Doctor, ExplainsTheDrivesWatchdogsWhereSpeedsAreSent) {
  BaseDeviceConfig base;
  for (const char* driver : {"handsfree", "can", "lcm", "none"}) {
    base.driver = driver;
    EXPECT_FALSE(checkWatchdog(base)) << driver;
  }
  base.speed_commands = true;
  base.driver = "can";
  ASSERT_TRUE(checkWatchdog(base));
  EXPECT_EQ(checkWatchdog(base)->level, Finding::kWarning);
  EXPECT_THAT(checkWatchdog(base)->fix,
              testing::AllOf(HasSubstr("enable_watchdog = True"), HasSubstr("watchdog_timeout = 0.5"),
                             HasSubstr("save_configuration()")));
  base.driver = "handsfree";
  ASSERT_TRUE(checkWatchdog(base));
  EXPECT_EQ(checkWatchdog(base)->level, Finding::kGood);
  base.driver = "lcm";
  EXPECT_FALSE(checkWatchdog(base)) << "who drives the base is not slamd";
}

TEST_F(Doctor, KnowsWhetherThisUserMayCommandOverTheSocket) {
  const std::string path = directory_ / "socket";
  EXPECT_EQ(checkSocket(path).level, Finding::kWarning);
  EXPECT_THAT(checkSocket(path).fix, HasSubstr("systemctl start slamd"));
  LocalSocket slamd(path);
  slamd.tend(Timestamp{});
  EXPECT_EQ(checkSocket(path).level, Finding::kGood) << checkSocket(path).what;
  if (geteuid() != 0) return;  // only root can become somebody else
  const pid_t stranger = fork();
  if (stranger == 0) {
    constexpr int kNobody = 65534;
    if (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0) _exit(1);
    const Finding finding = checkSocket(path);
    _exit(finding.level == Finding::kFault && finding.fix.find("usermod -aG slamd $USER") != std::string::npos ? 0 : 2);
  }
  int status = 0;
  waitpid(stranger, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST_F(Doctor, SaysWhereMapsCannotBeKept) {
  EXPECT_THAT(checkDisk("maps", directory_ / "none").fix, HasSubstr("mkdir -p"));
  EXPECT_NE(checkDisk("maps", directory_).level, Finding::kFault);
}

TEST_F(Doctor, ReadsStatesAndRatesOfARunningDaemon) {
  health_t health{};
  const auto device = [](const char* name, std::uint8_t state, double rate, double expected, const char* reason) {
    device_health_t d{};
    d.name = name;
    d.state = state;
    d.rate = rate;
    d.expected = expected;
    d.reason = reason;
    return d;
  };
  health.devices = {device("lidar", 2, 5.4, 5.5, ""), device("base", 2, 20.0, 50.0, ""),
                    device("depth", 4, 0.0, 30.0, "the camera has frozen"), device("imu", 200, 0.0, 0.0, "hostile")};
  const Findings findings = checkHealth(health);
  ASSERT_EQ(findings.size(), 4U);
  EXPECT_EQ(findings[0].level, Finding::kGood);
  EXPECT_EQ(findings[1].level, Finding::kWarning);
  EXPECT_THAT(findings[1].what, HasSubstr("20.0 Hz where 50.0 Hz are expected"));
  EXPECT_EQ(findings[2].level, Finding::kFault);
  EXPECT_THAT(findings[2].what, HasSubstr("the camera has frozen"));
  EXPECT_THAT(findings[2].fix, HasSubstr("journalctl"));
  EXPECT_EQ(findings[3].level, Finding::kFault) << "an unknown state is none that streams";
}

TEST_F(Doctor, CountsFaults) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(print({{Finding::kGood, "a", ""}, {Finding::kFault, "b", "do c"}, {Finding::kWarning, "d", "e"}}), 1);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::AllOf(HasSubstr("FAULT    b\n           fix: do c\n"),
                                                                     HasSubstr("1 faults, 1 warnings, 1 good")));
}

}  // namespace
}  // namespace slam
