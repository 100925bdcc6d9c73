// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine, with a board behind an emulated USB-serial converter.
#include <array>
#include <gtest/gtest.h>
#include <optional>

#include "drivers/byte_stream.hpp"
#include "firmware_if/robolink.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

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

}  // namespace
}  // namespace slam
