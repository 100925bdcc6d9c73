// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine, as root on a kernel with CAN: the real socket.
#include <cerrno>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "drivers/can/can_link.hpp"
#include "drivers/can/can_socket.hpp"
#include "runtime/clock.hpp"
#include "vm/virtual_can.hpp"

namespace slam::guest_socket_test {
namespace {

using namespace std::chrono_literals;
using test::ip;
using test::Peer;

constexpr can::Frame kEstimates{.id = 0x209, .size = 8, .data = {0x00, 0x00, 0xC0, 0x3F, 0x00, 0x00, 0x10, 0xC0}};
constexpr std::array<std::uint32_t, 2> kIds = {0x209, 0x309};

/// Everything the port has now.
std::vector<StampedCanFrame> take(CanPort& port) {
  std::vector<StampedCanFrame> frames;
  for (StampedCanFrame frame; port.receive(frame) == 0;) frames.push_back(frame);
  return frames;
}

class VirtualCanSocket : public test::VirtualCan {
 protected:
  void open() { ASSERT_EQ(port_->open("vcan0", kIds), 0); }
  std::unique_ptr<CanPort> port_ = makeSocketCanPort(monotonicNow);
};

TEST_F(VirtualCanSocket, StampsFramesWhenTheKernelReceivesThem) {
  open();
  Peer peer("vcan0");
  peer.send(0x209);
  std::this_thread::sleep_for(100ms);  // the kernel stamps nothing before a worker of its own has turned stamps on
  take(*port_);
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

TEST_F(VirtualCanSocket, TakesDataFramesOfItsIdsAlone) {
  open();
  Peer peer("vcan0");
  for (const std::uint32_t id : {0x208U, 0x20AU, 0x209U | CAN_EFF_FLAG, 0x209U | CAN_RTR_FLAG, 0x309U, 0x7FFU})
    peer.send(id);
  const auto frames = take(*port_);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].frame.id, 0x309U);
}

TEST_F(VirtualCanSocket, DoesNotTakeItsOwnFrames) {
  open();
  const auto other = makeSocketCanPort(monotonicNow);
  ASSERT_EQ(other->open("vcan0", kIds), 0);
  ASSERT_EQ(port_->send(kEstimates), 0);
  EXPECT_TRUE(take(*port_).empty());
  EXPECT_EQ(take(*other).size(), 1U);
}

TEST_F(VirtualCanSocket, DeliversErrorsOfTheControllerAndNotOfEveryFrame) {
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

TEST_F(VirtualCanSocket, WorksOnAfterDownAndUpWithTheSameSocket) {
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

}  // namespace
}  // namespace slam::guest_socket_test
