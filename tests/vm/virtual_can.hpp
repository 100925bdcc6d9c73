// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstdlib>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

namespace slam::test {

inline void ip(const std::string& arguments) {
  ASSERT_EQ(std::system(("/real/ip link " + arguments).c_str()), 0) << arguments;
}

/// The interface vcan0, where a test has left it.
inline void removeVirtualCan() {
  if (if_nametoindex("vcan0") != 0) ip("del vcan0");
}

/// Another program on the bus, with no more than the system's own calls.
class Peer {
 public:
  explicit Peer(const char* interface) : socket_(socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK, CAN_RAW)) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface));
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    int down = 0;  // ENETDOWN of an interface that is not up yet waits for the first call, unless it is taken away
    socklen_t size = sizeof down;
    EXPECT_EQ(getsockopt(socket_, SOL_SOCKET, SO_ERROR, &down, &size), 0);
  }
  ~Peer() { close(socket_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// The next frame that has come. @return false: none
  bool receive(can_frame& frame) { return read(socket_, &frame, sizeof frame) == static_cast<ssize_t>(sizeof frame); }

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

/// A test with an interface vcan0 of its own.
class VirtualCan : public testing::Test {
 protected:
  void SetUp() override {
    ip("add vcan0 type vcan");
    ip("set vcan0 up");
  }
  void TearDown() override { removeVirtualCan(); }
};

}  // namespace slam::test
