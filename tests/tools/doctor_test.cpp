// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/doctor.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <grp.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/local_socket.hpp"
#include "bus/problem_message.hpp"
#include "drivers/camera/fake_usb.hpp"
#include "drivers/can/fake_can_port.hpp"
#include "drivers/imu/iio_folder.hpp"
#include "drivers/virtual_line.hpp"
#include "firmware_if/can_vesc.hpp"
#include "problems/daemon.hpp"
#include "problems/devices.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"
#include "tools/sim/tcp_server.hpp"

namespace slam::doctor_test {
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

/// Somebody whose number and groups no file here has.
Account slamdOf(uid_t user, gid_t group) {
  Account account{.source = Account::kProcess,
                  .id = "812",
                  .is_service = true,
                  .user = user,
                  .group = group,
                  .groups = {},
                  .unit = {}};
  return account;
}

TEST_F(Doctor, NamesAnImuThatTheKernelReadsOrTheWayToOne) {
  const test::IioFolder folder;
  EXPECT_EQ(checkIio("mpu6050", folder.root()).level, Finding::kGood);
  EXPECT_THAT(checkIio("mpu6050", folder.root()).what, HasSubstr("imu: mpu6050"));
  const Finding finding = checkIio("bmi160", folder.root());
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.what, HasSubstr("imu: the kernel has no IMU bmi160"));
  EXPECT_THAT(finding.fix, HasSubstr("set imu.port"));
}

TEST_F(Doctor, NamesThePortsToChooseFromWhereOneIsMissing) {
  const Finding finding = checkPort("lidar", directory_ / "none", "lidar.port",
                                    {{"/dev/ttyUSB0", "10c4:ea60 CP2102 0001"}, {"/dev/ttyS0", ""}});
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.what, HasSubstr("none"));
  EXPECT_THAT(finding.fix, testing::AllOf(HasSubstr("/dev/ttyUSB0 (10c4:ea60 CP2102 0001)"), HasSubstr("lidar.port")));
  EXPECT_THAT(checkPort("lidar", directory_ / "none", "lidar.port", {}).fix, HasSubstr("no serial port"));
}

TEST_F(Doctor, DistinguishesAPortFromOneWithoutRights) {
  const fs::path port = directory_ / "port";
  std::ofstream(port) << "";
  EXPECT_EQ(checkPort("lidar", port, "lidar.port", {}).level, Finding::kGood);
  if (geteuid() == 0) return;  // root may open anything
  fs::permissions(port, fs::perms::none);
  const Finding finding = checkPort("lidar", port, "lidar.port", {});
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.fix, HasSubstr("usermod -aG dialout"));
}

TEST_F(Doctor, DistinguishesAnAbsentCameraFromAForbiddenOne) {
  FakeUsb usb;
  EXPECT_EQ(checkCamera(usb).level, Finding::kGood);
  usb.may_open = false;
  EXPECT_THAT(checkCamera(usb).what, HasSubstr("no right"));
  const fs::path device = directory_ / "sys/bus/usb/devices/1-1", node = directory_ / "dev/bus/usb/001/007";
  fs::create_directories(device);
  fs::create_directories(node.parent_path());
  std::ofstream(device / "idVendor") << "1d27\n";
  std::ofstream(device / "busnum") << "1\n";
  std::ofstream(device / "devnum") << "7\n";
  std::ofstream(node.c_str()) << "";
  const Account slamd = slamdOf(geteuid(), getegid()), stranger = slamdOf(54321, 54321);
  fs::permissions(node, fs::perms::owner_all);
  EXPECT_EQ(checkCamera(usb, slamd, directory_).level, Finding::kGood) << "whether or not who asks may";
  usb.may_open = true;
  EXPECT_THAT(checkCamera(usb, stranger, directory_).what, HasSubstr("user 54321) has no right"));
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

TEST_F(Doctor, DetectsACanInterfaceThatIsGoneDownOrShortOfRoom) {
  EXPECT_THAT(checkCan("can0", directory_).what, HasSubstr("no interface can0"));
  canInterface("0x40080", "256");
  EXPECT_THAT(checkCan("can0", directory_).what, HasSubstr("is down"));
  EXPECT_THAT(checkCan("can0", directory_).fix, HasSubstr("ip link set can0 up"));
  canInterface("0x40081", "10");
  EXPECT_EQ(checkCan("can0", directory_).level, Finding::kWarning);
  canInterface("0x40081", "256");
  EXPECT_EQ(checkCan("can0", directory_).level, Finding::kGood);
}

TEST_F(Doctor, NamesTheDevicesThatClaimOneName) {
  const auto device = [this](const char* number, const char* name, const char* serial, const char* socket) {
    fs::create_directories(directory_ / "run/udev/data");
    fs::create_directories(directory_ / "sys/dev/char");
    fs::create_directories(directory_ / "sys/devices" / name);
    fs::create_directory_symlink("../../devices/" + std::string(name), directory_ / "sys/dev/char" / number);
    std::ofstream(directory_ / "run/udev/data" / ("c" + std::string(number)))
        << "S:rplidar\nS:rplidar-" << serial << "\nS:serial/by-path/" << socket << "\nE:ID_SERIAL_SHORT=" << serial
        << "\n";
  };
  EXPECT_FALSE(checkClaimants("lidar", "/dev/rplidar", "lidar.port", directory_)) << "there is no udev";
  device("188:0", "ttyUSB0", "0001", "pci-0000:00:14.0-usb-0:1:1.0-port0");
  EXPECT_FALSE(checkClaimants("lidar", "/dev/rplidar", "lidar.port", directory_));
  device("188:1", "ttyUSB1", "0001", "pci-0000:00:14.0-usb-0:2:1.0-port0");
  const auto finding = checkClaimants("lidar", "/dev/rplidar", "lidar.port", directory_);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->level, Finding::kFault);
  EXPECT_THAT(finding->what, testing::AllOf(HasSubstr("two devices claim /dev/rplidar: ttyUSB0 and ttyUSB1"),
                                            HasSubstr("the same serial number 0001")));
  EXPECT_THAT(finding->fix, testing::AllOf(HasSubstr("/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0"),
                                           HasSubstr("/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0")));
  EXPECT_TRUE(checkClaimants("lidar", "/dev/rplidar-0001", "lidar.port", directory_));
  EXPECT_FALSE(checkClaimants("base", "/dev/handsfree", "base.port", directory_));
}

TEST_F(Doctor, FindsAdaptersThatHaveNoPort) {
  const fs::path devices = directory_ / "sys/bus/usb/devices", drivers = directory_ / "sys/bus/usb/drivers";
  const auto adapter = [&](const char* name, const char* vendor, const char* product, const char* driver) {
    fs::create_directories(devices / name / (std::string(name) + ":1.0"));
    std::ofstream(devices / name / "idVendor") << vendor << "\n";
    std::ofstream(devices / name / "idProduct") << product << "\n";
    if (*driver == '\0') return;
    fs::create_directories(drivers / driver);
    fs::create_directory_symlink(drivers / driver, devices / name / (std::string(name) + ":1.0") / "driver");
  };
  EXPECT_TRUE(checkAdapters(directory_).empty()) << "there is no USB";
  adapter("1-1", "10c4", "ea60", "cp210x");
  adapter("1-4", "1d27", "0601", "");
  EXPECT_TRUE(checkAdapters(directory_).empty());
  adapter("1-2", "10c4", "ea60", "usbfs");
  ASSERT_EQ(checkAdapters(directory_).size(), 1U);
  EXPECT_THAT(checkAdapters(directory_)[0].what, testing::AllOf(HasSubstr("10c4:ea60 at 1-2"), HasSubstr("brltty")));
  EXPECT_THAT(checkAdapters(directory_)[0].fix, HasSubstr("sudo apt remove brltty"));
  fs::remove_all(devices / "1-2");
  adapter("1-3", "1a86", "7523", "");
  ASSERT_EQ(checkAdapters(directory_).size(), 1U);
  EXPECT_THAT(checkAdapters(directory_)[0].fix, HasSubstr("sudo modprobe ch341"));
}

TEST_F(Doctor, NamesWhoElseHasAPortOpen) {
  const auto program = [&](const char* id, const char* name, const char* file) {
    fs::create_directories(directory_ / "proc" / id / "fd");
    std::ofstream(directory_ / "proc" / id / "comm") << name << "\n";
    fs::create_symlink(file, directory_ / "proc" / id / "fd" / "7");
  };
  EXPECT_FALSE(checkHolders("lidar", "/dev/ttyUSB0", directory_)) << "there is no /proc";
  program("100", "slamd", "/dev/ttyUSB0");
  program("200", "bash", "/dev/null");
  EXPECT_FALSE(checkHolders("lidar", "/dev/ttyUSB0", directory_));
  program("300", "ModemManager", "/dev/ttyUSB0");
  program("400", "agetty", "/dev/ttyS0");
  program("500", "minicom", "/dev/ttyUSB1");
  const auto lidar = checkHolders("lidar", "/dev/ttyUSB0", directory_);
  ASSERT_TRUE(lidar);
  EXPECT_EQ(lidar->level, Finding::kFault);
  EXPECT_THAT(lidar->what, HasSubstr("ModemManager (300) has /dev/ttyUSB0 open"));
  EXPECT_THAT(lidar->fix, HasSubstr("disable --now ModemManager"));
  EXPECT_THAT(checkHolders("base", "/dev/ttyS0", directory_)->fix, HasSubstr("serial-getty@ttyS0"));
  EXPECT_EQ(checkHolders("imu", "/dev/ttyUSB1", directory_)->fix, "sudo kill 500");
}

TEST_F(Doctor, FindsASecondSlamd) {
  for (const char* id : {"100", "200"}) {
    fs::create_directories(directory_ / "proc" / id);
    EXPECT_FALSE(checkSecondSlamd(directory_)) << id;
    std::ofstream(directory_ / "proc" / id / "comm") << "slamd\n";
  }
  const auto finding = checkSecondSlamd(directory_);
  ASSERT_TRUE(finding);
  EXPECT_THAT(finding->what, testing::AllOf(HasSubstr("100"), HasSubstr("200")));
}

TEST_F(Doctor, NamesTheTerminalBehindAnyName) {
  if (geteuid() != 0) GTEST_SKIP() << "only root makes devices";
  const fs::path node = directory_ / "rplidar";
  ASSERT_EQ(mknod(node.c_str(), S_IFCHR | 0600, makedev(188, 3)), 0);
  EXPECT_EQ(ttyNameOf(node, directory_ / "sys"), "") << "no such terminal";
  fs::create_directories(directory_ / "sys/dev/char");
  fs::create_directories(directory_ / "sys/devices/usb1/ttyUSB3/tty/ttyUSB3");
  fs::create_directory_symlink("../../devices/usb1/ttyUSB3/tty/ttyUSB3", directory_ / "sys/dev/char/188:3");
  EXPECT_EQ(ttyNameOf(node, directory_ / "sys"), "ttyUSB3");
  EXPECT_EQ(ttyNameOf("/dev/null"), "");
  EXPECT_EQ(ttyNameOf(directory_ / "none"), "");
}

TEST_F(Doctor, NamesTheCamerasThatThereAre) {
  const std::vector<CameraInfo> cameras = {{"1d27/0601@1/5", "PrimeSense PS1080", "640x480 at 30 Hz"}};
  EXPECT_EQ(checkCameraName("1d27/0601@1/5", cameras).level, Finding::kGood);
  const Finding finding = checkCameraName("1d27/0601@1/4", cameras);
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.fix, testing::AllOf(HasSubstr("1d27/0601@1/5 (PrimeSense PS1080, 640x480 at 30 Hz)"),
                                          HasSubstr("set depth.uri")));
  EXPECT_THAT(checkCameraName("1d27/0601@1/4", {}).fix, HasSubstr("OpenNI2 finds none"));
}

TEST_F(Doctor, NamesTheNodesOfDrivesThatSend) {
  test::FakeCanBus bus;
  test::FakeCanPort port(bus);
  const auto heard = [&](std::vector<int> nodes) {
    bus.incoming.clear();
    for (const int node : nodes) bus.put(can::odrive::encodeHeartbeat(node, {.state = 8}));
    return checkDrives({.left_node = 16, .right_node = 24}, port, std::chrono::milliseconds(20));
  };
  EXPECT_EQ(heard({16, 24}).level, Finding::kGood);
  EXPECT_THAT(heard({}).fix, HasSubstr("check the bit rate"));
  const Finding defaults = heard({1, 0});
  EXPECT_EQ(defaults.level, Finding::kFault);
  EXPECT_THAT(defaults.what, HasSubstr("can.left_node = 16"));
  EXPECT_THAT(defaults.fix, HasSubstr("nodes that send heartbeats: 0, 1; set can.left_node"));
  EXPECT_THAT(heard({16, 25}).what, HasSubstr("can.right_node = 24"));
  EXPECT_FALSE(bus.open) << "it is closed again";
  EXPECT_TRUE(bus.sent.empty());
}

TEST_F(Doctor, NamesTheFramesThatAVescDoesNotSend) {
  namespace vesc = can::vesc;
  test::FakeCanBus bus;
  test::FakeCanPort port(bus);
  const auto heard = [&](std::vector<can::Frame> frames) {
    bus.incoming.clear();
    for (const can::Frame& frame : frames) bus.put(frame);
    return checkDrives({.protocol = can::Protocol::kVesc, .left_node = 10, .right_node = 200}, port,
                       std::chrono::milliseconds(20));
  };
  const can::Frame left = vesc::encode(10, vesc::Status{}), right = vesc::encode(200, vesc::Status{});
  const can::Frame left5 = vesc::encode(10, vesc::Status5{}), right5 = vesc::encode(200, vesc::Status5{});
  EXPECT_EQ(heard({left, left5, right, right5}).level, Finding::kGood);
  EXPECT_THAT(heard({left, right, right5}).what, HasSubstr("no STATUS_5 of the left"));
  EXPECT_THAT(heard({left, left5, right5}).what, HasSubstr("no STATUS of the right"));
  EXPECT_THAT(heard({left, left5}).what, HasSubstr("no frame of the right wheel's VESC (can.right_node = 200)"));
  EXPECT_FALSE(bus.open);
  bus.incoming.clear();
  const can::Frame other = vesc::encode(3, vesc::Status{});
  for (const can::Frame& frame : {left, other, left5, left}) bus.put(frame);
  EXPECT_EQ(listenForVescs("can0", port, std::chrono::milliseconds(5)), (std::vector{3, 10}));
  EXPECT_FALSE(bus.open);
}

TEST_F(Doctor, ExplainsTheDrivesWatchdogsWhereSpeedsAreSent) {
  test::FakeCanBus bus;
  bus.open_error = ENODEV;
  test::FakeCanPort port(bus);
  BaseDeviceConfig base;
  for (std::size_t i = 0; i < kWords<BaseDriver>.size(); ++i) {
    base.driver = static_cast<BaseDriver>(i);
    EXPECT_FALSE(checkWatchdog(base, {}, port)) << wordOf(base.driver);
  }
  base.speed_commands = true;
  base.driver = BaseDriver::kCan;
  ASSERT_TRUE(checkWatchdog(base, {}, port));
  EXPECT_EQ(checkWatchdog(base, {}, port)->level, Finding::kWarning);
  EXPECT_THAT(checkWatchdog(base, {.protocol = can::Protocol::kVesc}, port)->what, HasSubstr("VESC"));
  base.driver = BaseDriver::kHandsfree;
  ASSERT_TRUE(checkWatchdog(base, {}, port));
  EXPECT_EQ(checkWatchdog(base, {}, port)->level, Finding::kGood);
  for (const auto driver :
       {BaseDriver::kRosArduinoBridge, BaseDriver::kKobuki, BaseDriver::kRoboclaw, BaseDriver::kFrame}) {
    base.driver = driver;
    ASSERT_TRUE(checkWatchdog(base, {}, port));
    EXPECT_EQ(checkWatchdog(base, {}, port)->level, Finding::kGood);
  }
  EXPECT_THAT(checkWatchdog(base, {}, port)->what, HasSubstr("0.2 s after the last command"));
  base.driver = BaseDriver::kVesc;
  EXPECT_EQ(checkWatchdog(base, {}, port)->level, Finding::kWarning) << "it is a setting";
  base.driver = BaseDriver::kCreate2;
  ASSERT_TRUE(checkWatchdog(base, {}, port));
  EXPECT_EQ(checkWatchdog(base, {}, port)->level, Finding::kWarning) << "it has none";
  EXPECT_FALSE(checkWatchdog(base, {}, port)->fix.empty());
  base.driver = BaseDriver::kLcm;
  EXPECT_FALSE(checkWatchdog(base, {}, port)) << "who drives the base is not slamd";
}

/// What doctor finds where connecting ends so.
Finding checkWhere(const ProblemKind& kind) {
  const std::string path = "tcp://192.168.0.10:10940";
  return checkTcpLidar("hokuyo", path, [&](const std::string&, int) {
    return OpenedPort{nullptr, {kind, {}, {path}}};
  });
}

TEST_F(Doctor, DistinguishesLidarsOnTheNetworkByWhatIsWrong) {
  EXPECT_THAT(checkWhere(problem::kTcpNoWay).what, HasSubstr("no way leads to tcp://192.168.0.10:10940"));
  EXPECT_THAT(checkWhere(problem::kTcpNoReply).what, HasSubstr("does not reply"));
  EXPECT_EQ(checkWhere(problem::kTcpRefused).level, Finding::kFault);
  EXPECT_FALSE(checkWhere(problem::kTcpRefused).fix.empty());

  sim::TcpServer server(0);
  const std::string path = "tcp://127.0.0.1:" + std::to_string(server.port());
  const Finding silent = checkTcpLidar("sick", path);
  EXPECT_EQ(silent.level, Finding::kFault);
  EXPECT_THAT(silent.what, HasSubstr("takes the connection, but sends nothing"));
  EXPECT_THAT(checkTcpLidar("sick", "tcp://lidar:2112").what, HasSubstr("is no address"));
}

TEST_F(Doctor, AsksALidarOnTheNetworkWhoItIs) {
  sim::ScipEmulator device([](Timestamp, double) { return 2.0; }, sim::scipModels().front());
  std::vector<std::uint8_t> answers;
  test::VirtualLine line(
      [&](std::span<const std::uint8_t> bytes) { device.receive(bytes, test::virtual_now, answers); },
      [&](std::vector<std::uint8_t>& out) {
        device.stream(test::virtual_now, answers);
        out = std::exchange(answers, {});
      });
  const std::string path = "tcp://192.168.0.10:10940";
  for (const char* driver : {"hokuyo", "auto"}) {
    const Finding found = checkTcpLidar(driver, path, line.opener(), test::virtualNow);
    EXPECT_EQ(found.level, Finding::kGood) << found.what;
  }
  const Finding other = checkTcpLidar("sick", path, line.opener(), test::virtualNow);
  EXPECT_EQ(other.level, Finding::kFault);
  EXPECT_THAT(other.fix, HasSubstr("hokuyo"));
}

TEST_F(Doctor, ReportsWhetherThisUserMayCommandOverTheSocket) {
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

TEST_F(Doctor, EvaluatesAFolderByWhoRunsSlamdAndGivesItToNobodyElse) {
  constexpr uid_t kSlamd = 54321;
  const fs::path maps = directory_ / "maps";
  fs::create_directories(maps);
  fs::permissions(maps, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec);
  const Account owner = slamdOf(geteuid(), getegid()), stranger = slamdOf(kSlamd, kSlamd);
  EXPECT_EQ(checkDisk("maps", maps, owner).level, Finding::kGood) << checkDisk("maps", maps, owner).what;
  const Finding finding = checkDisk("maps", maps, stranger);
  EXPECT_EQ(finding.level, Finding::kFault) << "although who asks may write there";
  EXPECT_THAT(finding.fix, testing::AllOf(HasSubstr("chown -R 54321:54321 "), testing::Not(HasSubstr("$USER"))));
  EXPECT_THAT(checkDisk("maps", directory_ / "none", stranger).fix, HasSubstr("install -d -o 54321 -g 54321 -m 750 "));
  // A folder above that may not be entered, and a group that may write.
  fs::permissions(maps, fs::perms::all);
  fs::permissions(directory_, fs::perms::owner_all);
  EXPECT_EQ(checkDisk("maps", maps, stranger).level, Finding::kFault);
  fs::permissions(directory_, fs::perms::owner_all | fs::perms::others_exec);
  EXPECT_NE(checkDisk("maps", maps, stranger).level, Finding::kFault);
  fs::permissions(maps, fs::perms::owner_all | fs::perms::group_all);
  EXPECT_EQ(checkDisk("maps", maps, stranger).level, Finding::kFault);
  Account member = stranger;
  member.groups = {getegid()};
  fs::permissions(directory_, fs::perms::owner_all | fs::perms::group_exec);
  EXPECT_NE(checkDisk("maps", maps, member).level, Finding::kFault);
}

TEST_F(Doctor, EvaluatesAPortByWhoRunsSlamd) {
  const fs::path port = directory_ / "port";
  std::ofstream(port) << "";
  fs::permissions(port, fs::perms::owner_all);
  const Account stranger = slamdOf(54321, 54321);
  EXPECT_EQ(checkPort("lidar", port, "lidar.port", {}, slamdOf(geteuid(), getegid())).level, Finding::kGood);
  const Finding finding = checkPort("lidar", port, "lidar.port", {}, stranger);
  EXPECT_EQ(finding.level, Finding::kFault) << "although who asks may open it";
  EXPECT_THAT(finding.what, HasSubstr("user 54321"));
  EXPECT_THAT(finding.fix, testing::AllOf(HasSubstr("KERNEL==\"port\""), testing::Not(HasSubstr("path and cable"))))
      << "no USB adapter";
}

TEST_F(Doctor, ShowsWhatTheThreadsOfARunningSlamdHave) {
  const auto process = [&](const char* limit, const char* locked, const char* policy) {
    fs::create_directories(directory_ / "proc/812/task/815");
    std::ofstream(directory_ / "proc/812/limits")
        << "Max locked memory         " << limit << "      8388608              bytes     \n"
        << "Max realtime priority     " << (policy[0] == '1' ? "95" : "0") << "                   95\n";
    std::ofstream(directory_ / "proc/812/status")
        << "Uid:\t990\t991\t991\t991\nGid:\t992\t993\t993\t993\nGroups:\t20 44 \nVmLck:\t   " << locked
        << " kB\nCapEff:\t0000000000000000\n";
    std::ofstream(directory_ / "proc/812/cgroup") << "0::/system.slice/slamd.service\n";
    std::ofstream(directory_ / "proc/812/task/815/stat") << "815 (a) b) S 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 "
                                                            "19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 70 "
                                                         << "80 " << policy << " 0 0\n";
  };
  EXPECT_FALSE(accountOfProcess("812", directory_));
  process("unlimited", "65536", "1");
  const auto slamd = accountOfProcess("812", directory_);
  ASSERT_TRUE(slamd);
  EXPECT_TRUE(slamd->is_service);
  EXPECT_EQ(slamd->user, 991U);
  EXPECT_TRUE(slamd->has(993) && slamd->has(20) && slamd->has(44) && !slamd->has(992));
  Findings findings = checkRealtime(80, *slamd, directory_);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].level, Finding::kGood) << findings[0].what;
  EXPECT_THAT(findings[0].what, HasSubstr("1 threads of slamd (process 812"));
  EXPECT_EQ(findings[1].level, Finding::kGood) << findings[1].what;
  EXPECT_THAT(findings[1].what, HasSubstr("64 MiB"));
  process("8388608", "0", "0");
  findings = checkRealtime(80, *slamd, directory_);
  EXPECT_EQ(findings[0].level, Finding::kWarning) << "whatever who asks may do";
  EXPECT_THAT(findings[0].what, HasSubstr("priority 80 where the limit is 0"));
  EXPECT_THAT(findings[0].fix, testing::AllOf(HasSubstr("systemctl edit slamd"), HasSubstr("LimitRTPRIO=95")));
  EXPECT_EQ(findings[1].level, Finding::kWarning);
  EXPECT_THAT(findings[1].what, HasSubstr("only 8 MiB may be"));
  EXPECT_THAT(findings[1].fix, HasSubstr("LimitMEMLOCK=infinity"));
}

TEST_F(Doctor, EvaluatesTheUnitWhereNoSlamdRuns) {
  ServiceAccount unit{.user = "nobody",
                      .group = "",
                      .further_groups = {"no such group"},
                      .priority_limit = "50:95",
                      .lock_limit = "8M"};
  const auto account = accountOfUnit(unit);
  if (!account) GTEST_SKIP() << "there is no user nobody";
  EXPECT_EQ(account->source, Account::kUnit);
  Findings findings = checkRealtime(80, *account);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_THAT(findings[0].what, testing::AllOf(HasSubstr("slamd.service (user nobody)"), HasSubstr("the limit is 50")));
  EXPECT_THAT(findings[1].what, HasSubstr("its limit is 8M"));
  unit.priority_limit = "95";
  unit.lock_limit = "infinity";
  for (const Finding& finding : checkRealtime(80, *accountOfUnit(unit)))
    EXPECT_EQ(finding.level, Finding::kGood) << finding.what;
  EXPECT_FALSE(accountOfUnit({.user = "no such user"}));
}

TEST_F(Doctor, NamesWhyARunningSlamdDoesNotAnswer) {
  const Account slamd = slamdOf(1, 1);
  const auto silence = [&](const char* state) {
    fs::create_directories(directory_ / "proc/812");
    std::ofstream(directory_ / "proc/812/stat") << "812 (slamd) " << state << " 1 812 812 0\n";
    return checkSilence(slamd, directory_);
  };
  for (const char* state : {"S", "R", "D", "T"}) EXPECT_EQ(silence(state).level, Finding::kFault) << state;
  EXPECT_THAT(silence("T").fix, HasSubstr("kill -CONT 812"));
  EXPECT_THAT(silence("S").fix,
              testing::AllOf(HasSubstr("systemctl restart slamd"), testing::Not(HasSubstr("systemctl start"))));
  EXPECT_THAT(checkSilence(slamd, directory_ / "none").what, HasSubstr("has ended"));
}

TEST_F(Doctor, FindsTheSlamdThatListens) {
  const std::string path = directory_ / "socket";
  EXPECT_FALSE(accountOfSlamd(path));
  LocalSocket slamd(path);
  slamd.tend(Timestamp{});
  const auto found = accountOfSlamd(path);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->id, std::to_string(getpid())) << "it is this program";
  EXPECT_EQ(found->user, geteuid());
}

TEST_F(Doctor, ReportsWhereMapsCannotBeKept) {
  EXPECT_THAT(checkDisk("maps", directory_ / "none").fix, HasSubstr("mkdir -p"));
  EXPECT_NE(checkDisk("maps", directory_).level, Finding::kFault);
}

TEST_F(Doctor, DistinguishesAReadOnlyDiskFromAMissingRight) {
  const pid_t child = fork();
  if (child == 0) {
    const char* const folder = directory_.c_str();
    if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", folder, "tmpfs", MS_RDONLY, nullptr) != 0)
      _exit(77);
    const Finding finding = checkDisk("maps", directory_);
    _exit(finding.level == Finding::kFault && finding.what.find("read-only") != std::string::npos &&
                  finding.fix.find("dmesg") != std::string::npos
              ? 0
              : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "no right to mount a disk";
  EXPECT_EQ(status, 0);
}

TEST_F(Doctor, ReportsThatTheFieldLogStopsForLackOfRoom) {
  EXPECT_FALSE(checkLogFloor(directory_, 0.0));
  const auto finding = checkLogFloor(directory_, 1e12);
  ASSERT_TRUE(finding);
  EXPECT_THAT(finding->what, HasSubstr("where log.floor keeps"));
  EXPECT_FALSE(checkLogFloor(directory_ / "no/such", 1e12));
}

problems_t messageOf(std::vector<problem_t> problems) {
  problems_t message{};
  message.problems = std::move(problems);
  message.nproblems = static_cast<std::int32_t>(message.problems.size());
  return message;
}

TEST_F(Doctor, ReportsWhatThePoseWaitsForAndWhatIsNotStored) {
  const Problem waits(problem::kNoScans), full(problem::kDiskFull, {}, {"/maps", "", " (12 MB free)"});
  const Findings findings = checkHealth({}, messageOf({toMessage("pose", waits, false), toMessage("map", full, true)}),
                                        std::chrono::seconds(60));
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_EQ(findings[0].what, "slamd, pose: " + waits.cause());
  EXPECT_EQ(findings[0].level, Finding::kWarning);
  EXPECT_EQ(findings[1].what, "slamd, map: " + full.cause());
  EXPECT_EQ(findings[1].level, Finding::kFault);
  EXPECT_EQ(findings[1].fix, full.fix());
  EXPECT_THAT(findings[2].what, HasSubstr("stamps are 60.0 s ahead of it"));
}

TEST_F(Doctor, ReportsThatSlamdWaitsForTheCpu) {
  const auto thread = [&](const char* id, const char* waited) {
    fs::create_directories(directory_ / "proc/812/task" / id);
    std::ofstream(directory_ / "proc/812/task" / id / "comm") << "graph\n";
    std::ofstream(directory_ / "proc/812/task" / id / "schedstat") << "7000000000 " << waited << " 12\n";
  };
  thread("815", "1000000000"), thread("816", "9000000000");
  const auto before = cpuWaits("812", directory_);
  EXPECT_EQ(before.size(), 2U);
  thread("815", "1900000000"), thread("817", "60000000000");
  EXPECT_FALSE(checkLoad(before, cpuWaits("812", directory_), std::chrono::seconds(2))) << "less than half of the time";
  const auto finding = checkLoad(before, cpuWaits("812", directory_), std::chrono::seconds(1));
  ASSERT_TRUE(finding);
  EXPECT_THAT(finding->what, HasSubstr("the computer is overloaded: slamd's thread graph waited 90 % of the time"));
  EXPECT_TRUE(cpuWaits("none", directory_).empty());
}

TEST_F(Doctor, ReadsStatesAndRatesOfARunningDaemon) {
  health_t health{};
  const auto device = [](const char* name, std::uint8_t state, double rate, double expected) {
    device_health_t d{};
    d.name = name;
    d.state = state;
    d.rate = rate;
    d.expected = expected;
    return d;
  };
  health.devices = {device("lidar", 2, 5.4, 5.5), device("base", 2, 20.0, 50.0), device("depth", 4, 0.0, 30.0),
                    device("imu", 200, 0.0, 0.0)};
  const Problem frozen(problem::kCameraFrozen);
  const Findings findings = checkHealth(health, messageOf({toMessage("depth", frozen, true)}));
  ASSERT_EQ(findings.size(), 4U);
  EXPECT_EQ(findings[0].level, Finding::kGood);
  EXPECT_EQ(findings[1].level, Finding::kWarning);
  EXPECT_THAT(findings[1].what, HasSubstr("20.0 Hz where 50.0 Hz are expected"));
  EXPECT_EQ(findings[2].level, Finding::kFault);
  EXPECT_EQ(findings[2].what, "slamd, depth: FAULT: " + frozen.cause());
  EXPECT_THAT(findings[2].fix, HasSubstr("journalctl"));
  EXPECT_EQ(findings[3].level, Finding::kFault) << "an unknown state is none that streams";
}

TEST_F(Doctor, GivesTheFixOfEachProblem) {
  health_t health{};
  device_health_t base{}, lidar{};
  base.name = "base";
  base.state = 2;
  base.rate = base.expected = 5.0;
  lidar.name = "lidar";
  lidar.state = 4;
  health.devices = {base, lidar};
  const Problem slow(problem::kSlowEstimates, {200.0}, {"left"}), rival(problem::kRival, {}, {"udpm://"}),
      board(problem::kOtherDevice, {}, {"the HandsFree board", "lidar", "base"});
  const Findings findings =
      checkHealth(health, messageOf({toMessage("base", slow, false), toMessage("lidar", board, true),
                                     toMessage("SLAM_POSE", rival, true)}));
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_EQ(findings[0].level, Finding::kWarning);
  EXPECT_EQ(findings[0].what, "slamd, base: STREAMING: " + slow.cause() + "; " + slow.meanwhile());
  EXPECT_EQ(findings[0].fix, slow.fix());
  EXPECT_EQ(findings[1].level, Finding::kFault);
  EXPECT_EQ(findings[1].fix, board.fix());
  EXPECT_EQ(findings[2].level, Finding::kFault);
  EXPECT_EQ(findings[2].fix, rival.fix());
}

TEST_F(Doctor, CountsFaults) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(print({{Finding::kGood, "a", ""}, {Finding::kFault, "b", "do c"}, {Finding::kWarning, "d", "e"}}), 1);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::AllOf(HasSubstr("FAULT    b\n           fix: do c\n"),
                                                                     HasSubstr("1 faults, 1 warnings, 1 good")));
}

}  // namespace
}  // namespace slam::doctor_test
