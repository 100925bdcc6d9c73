// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine, as root on a kernel with CAN: the real socket, and the driver on it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "drivers/byte_stream.hpp"
#include "drivers/can_base.hpp"
#include "drivers/can_socket.hpp"
#include "firmware_if/robolink.hpp"
#include "runtime/clock.hpp"
#include "support/process.hpp"
#include "tools/sim/can_bus.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr can::Frame kEstimates{.id = 0x209, .size = 8, .data = {0x00, 0x00, 0xC0, 0x3F, 0x00, 0x00, 0x10, 0xC0}};
constexpr std::array<std::uint32_t, 2> kIds = {0x209, 0x309};

void ip(const std::string& arguments) {
  ASSERT_EQ(std::system(("/real/ip link " + arguments).c_str()), 0) << arguments;
}

/// Another program on the bus, with no more than the system's own calls.
class Peer {
 public:
  explicit Peer(const char* interface) : socket_(socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK, CAN_RAW)) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface));
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Peer() { close(socket_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  void send(std::uint32_t id, std::array<std::uint8_t, 8> data = {}, std::uint8_t size = 8) {
    can_frame frame{};
    frame.can_id = id;
    frame.len = size;
    std::copy(data.begin(), data.end(), frame.data);
    EXPECT_EQ(write(socket_, &frame, sizeof frame), static_cast<ssize_t>(sizeof frame));
  }

 private:
  int socket_;
};

/// Everything the port has now.
std::vector<StampedCanFrame> take(CanPort& port) {
  std::vector<StampedCanFrame> frames;
  for (StampedCanFrame frame; port.receive(frame) == 0;) frames.push_back(frame);
  return frames;
}

class VirtualCan : public testing::Test {
 protected:
  void SetUp() override {
    ip("add vcan0 type vcan");
    ip("set vcan0 up");
  }
  void TearDown() override { std::system("/real/ip link del vcan0 2>/dev/null"); }
  void open() { ASSERT_EQ(port_->open("vcan0", kIds), 0); }

  std::unique_ptr<CanPort> port_ = makeSocketCanPort(monotonicNow);
};

TEST_F(VirtualCan, StampsFramesWhenTheKernelReceivesThem) {
  open();
  Peer peer("vcan0");
  const Timestamp before = monotonicNow();
  peer.send(0x209, kEstimates.data);
  const Timestamp after = monotonicNow();
  std::this_thread::sleep_for(100ms);  // a thread that reads late
  const auto frames = take(*port_);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].frame, kEstimates);
  EXPECT_GE(frames[0].stamp, before - 2ms);
  EXPECT_LE(frames[0].stamp, after + 2ms);
}

TEST_F(VirtualCan, TakesDataFramesOfItsIdsAlone) {
  open();
  Peer peer("vcan0");
  for (const std::uint32_t id : {0x208U, 0x20AU, 0x209U | CAN_EFF_FLAG, 0x209U | CAN_RTR_FLAG, 0x309U, 0x7FFU})
    peer.send(id);
  const auto frames = take(*port_);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].frame.id, 0x309U);
}

TEST_F(VirtualCan, DoesNotTakeItsOwnFrames) {
  open();
  const auto other = makeSocketCanPort(monotonicNow);
  ASSERT_EQ(other->open("vcan0", kIds), 0);
  ASSERT_EQ(port_->send(kEstimates), 0);
  EXPECT_TRUE(take(*port_).empty());
  EXPECT_EQ(take(*other).size(), 1U);
}

TEST_F(VirtualCan, DeliversErrorsOfTheControllerAndNotOfEveryFrame) {
  CanLink link(makeSocketCanPort(monotonicNow), "vcan0", {kIds.begin(), kIds.end()});
  StampedCanFrame frame;
  const auto tick = [&] {
    link.tick(monotonicNow());
    EXPECT_FALSE(link.receive(frame)) << "error frames are no data";
  };
  tick();
  Peer peer("vcan0");
  peer.send(0x20000004, {0, 0x08});  // warning
  tick();
  EXPECT_EQ(link.state(), CanLinkState::kUp);
  peer.send(0x20000004, {0, 0x20});  // passive
  tick();
  EXPECT_EQ(link.state(), CanLinkState::kErrorPassive);
  peer.send(0x20000040);
  tick();
  EXPECT_EQ(link.state(), CanLinkState::kBusOff);
  peer.send(0x20000100);
  tick();
  EXPECT_EQ(link.state(), CanLinkState::kUp);

  open();
  for (int i = 0; i < 100; ++i) peer.send(0x20000088);  // a frame's error in the protocol
  EXPECT_TRUE(take(*port_).empty());
  peer.send(0x20000040);
  EXPECT_EQ(take(*port_).size(), 1U);
}

TEST_F(VirtualCan, WorksOnAfterDownAndUpWithTheSameSocket) {
  open();
  EXPECT_EQ(port_->interfaceError(), 0);
  ip("set vcan0 down");
  EXPECT_EQ(port_->pendingError(), ENETDOWN);
  EXPECT_EQ(port_->interfaceError(), ENETDOWN);
  EXPECT_EQ(port_->send(kEstimates), ENETDOWN);
  ip("set vcan0 up");
  EXPECT_EQ(port_->interfaceError(), 0);
  take(*port_);
  Peer peer("vcan0");
  peer.send(0x209);
  EXPECT_EQ(take(*port_).size(), 1U);
}

/// The driver on one interface and the emulator on another, in real time.
class Pair {
 public:
  Pair(const std::string& driver, const std::string& emulator)
      : driver_({.interface = driver, .commands = true}, monotonicNow,
                {.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); },
                 .imu = [this](const ImuSample& sample) { imu_.push_back(sample); }}),
        interface_(emulator) {
    plug();
  }
  void plug() { bus_.emplace(interface_, 1); }
  void unplug() { bus_.reset(); }

  void runFor(Duration time) {
    runUntil([] { return false; }, time);
  }
  /// @return [s] how long it took, the limit when the condition never held
  template <typename Condition>
  double runUntil(Condition&& condition, Duration limit) {
    const Timestamp begin = monotonicNow();
    for (Timestamp now = begin; now - begin < limit; now = monotonicNow()) {
      const double t = toSeconds(now - origin_);
      const auto noise = static_cast<float>(0.01 * std::sin(1000.0 * t));
      if (bus_) bus_->step(now, {.angles = {2.0 * t, 3.0 * t}, .gyro = {noise, 0, 0.5F}, .accel = {0, 0, 9.75F}});
      driver_.tick();
      if (condition()) return toSeconds(now - begin);
      std::this_thread::sleep_for(2ms);
    }
    return toSeconds(limit);
  }
  bool streaming() {
    return driver_.wheelStatus().state == DeviceState::kStreaming &&
           driver_.imuStatus().state == DeviceState::kStreaming;
  }
  std::string reason() { return driver_.wheelStatus().reason.load(); }

  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  CanBase driver_;
  std::optional<sim::CanBus> bus_;

 private:
  std::string interface_;
  Timestamp origin_ = monotonicNow();
};

void expectSamples(Pair& pair) {
  pair.runFor(3s);
  EXPECT_TRUE(pair.streaming()) << pair.reason();
  EXPECT_GT(pair.wheels_.size(), 200U);  // 300 where the machine keeps up
  EXPECT_GT(pair.imu_.size(), 200U);
  EXPECT_EQ(pair.driver_.wheelStatus().rejects.load(), 0);
  const WheelAngles& first = pair.wheels_[10];
  const WheelAngles& last = pair.wheels_.back();
  const double elapsed = toSeconds(last.stamp - first.stamp);
  EXPECT_NEAR((last.left - first.left) / elapsed, 2.0, 0.05);
  EXPECT_NEAR((last.right - first.right) / elapsed, 3.0, 0.05);
  EXPECT_NEAR(pair.imu_.back().gyro.z(), 0.5, 1e-3);
  pair.driver_.command(6.2831853, -6.2831853);
  pair.runFor(200ms);
  EXPECT_GE(pair.bus_->emulator().commands(), 8);
  EXPECT_FLOAT_EQ(pair.bus_->emulator().asked()[0], 1.0F);
  EXPECT_FLOAT_EQ(pair.bus_->emulator().asked()[1], -1.0F);
}

TEST_F(VirtualCan, CarriesWheelsImuAndCommands) {
  Pair pair("vcan0", "vcan0");
  expectSamples(pair);
}

TEST_F(VirtualCan, IsMissedWithinASecondAndUsedAgain) {
  Pair pair("vcan0", "vcan0");
  const auto streaming = [&] { return pair.streaming(); };
  const auto lost = [&] { return !pair.streaming(); };
  ASSERT_LT(pair.runUntil(streaming, 5s), 2.0);

  ip("set vcan0 down");
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "vcan0 is down: ip link set vcan0 up");
  ip("set vcan0 up");
  EXPECT_LT(pair.runUntil(streaming, 5s), 2.0);

  pair.unplug();
  ip("del vcan0");
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "interface vcan0 is gone: adapter unplugged?");
  pair.runFor(1s);
  ip("add vcan0 type vcan");
  ip("set vcan0 up");
  pair.plug();
  EXPECT_LT(pair.runUntil(streaming, 5s), 3.0);
  EXPECT_EQ(pair.driver_.linkCounters().opened, 2U);

  Peer peer("vcan0");
  peer.send(0x20000040);
  pair.bus_->emulator().inject("silent", 1);
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "vcan0 is bus-off: check wiring and termination");
  peer.send(0x20000100);
  pair.bus_->emulator().inject("silent", 0);
  EXPECT_LT(pair.runUntil(streaming, 5s), 2.0);

  pair.bus_->emulator().inject("silent", 1);
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_THAT(pair.reason(), HasSubstr("no frames of the left wheel (node 0x10)"));
}

TEST_F(VirtualCan, IsFedBySlamSim) {
  ip("del vcan0");
  const std::vector<std::string> command = {"slam-sim", "--devices", "/tmp/devices", "--can", "vcan0"};
  EXPECT_EQ(test::Process(command, "/tmp/sim.txt").wait(20s), 1) << "an interface that is not there";
  ip("add vcan0 type vcan");
  ip("set vcan0 up");
  test::Process simulator(command, "/tmp/sim.txt");
  int wheels = 0, samples = 0;
  CanBase driver({.interface = "vcan0"}, monotonicNow,
                 {.wheels = [&](const WheelAngles&) { ++wheels; }, .imu = [&](const ImuSample&) { ++samples; }});
  for (const Timestamp end = monotonicNow() + 20s; (wheels < 200 || samples < 200) && monotonicNow() < end;) {
    driver.tick();
    std::this_thread::sleep_for(2ms);
  }
  EXPECT_EQ(driver.wheelStatus().state, DeviceState::kStreaming) << driver.wheelStatus().reason.load();
  EXPECT_EQ(driver.imuStatus().state, DeviceState::kStreaming) << driver.imuStatus().reason.load();
  EXPECT_GE(wheels, 200);
  EXPECT_GE(samples, 200);
  EXPECT_EQ(driver.wheelStatus().rejects.load(), 0);
  simulator.signal(SIGTERM);
  EXPECT_EQ(simulator.wait(20s), 0);
  if (HasFailure()) std::system("cat /tmp/sim.txt");
}

TEST(UsbSerial, OpensByNameSetsDtrAndPassesData) {
  OpenedPort port = openPort("/dev/ttyUSB0", 921600);
  ASSERT_TRUE(port.stream) << port.problem;
  EXPECT_STREQ(openPort("/dev/ttyUSB0", 921600).problem, "the port is in use by another program");
  EXPECT_TRUE(port.stream->setDtr(false));
  EXPECT_TRUE(port.stream->setDtr(true));
  std::array<std::uint8_t, robolink::kMaxFrame> request;
  const auto size =
      robolink::encodeFrame(robolink::kMaster, robolink::kSlave, robolink::Command::kGetSystemInfo, {}, request);
  robolink::Decoder decoder;
  std::optional<robolink::Frame> answer;
  for (const Timestamp end = monotonicNow() + 10s; !answer && monotonicNow() < end;) {
    ASSERT_TRUE(port.stream->write({request.data(), size}));
    std::array<std::uint8_t, 256> chunk;
    const ReadResult result = port.stream->read(chunk, 500ms);
    for (std::size_t i = 0; i < result.size && !answer; ++i) answer = decoder.push(chunk[i]);
  }
  ASSERT_TRUE(answer) << "of the board, to any request before its handshake";
  EXPECT_EQ(answer->command, static_cast<std::uint8_t>(robolink::Command::kShakingHands));
}

TEST(EmulatedController, CarriesWheelsImuAndCommandsAtItsBitRate) {
  Pair pair("can0", "can1");
  expectSamples(pair);
}

TEST(EmulatedController, IsMissedWhenItIsTakenDownAndUsedAgain) {
  Pair pair("can0", "can1");
  const auto streaming = [&] { return pair.streaming(); };
  ASSERT_LT(pair.runUntil(streaming, 5s), 2.0);
  ip("set can0 down");
  EXPECT_LT(pair.runUntil([&] { return !pair.streaming(); }, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "can0 is down: ip link set can0 up");
  ip("set can0 up");
  EXPECT_LT(pair.runUntil(streaming, 5s), 2.0);
}

}  // namespace
}  // namespace slam
