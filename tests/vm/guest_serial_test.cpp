// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine, with a board behind an emulated USB-serial converter.
#include <array>
#include <asm/termbits.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <optional>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "drivers/byte_stream.hpp"
#include "drivers/serial_port.hpp"
#include "firmware_if/robolink.hpp"
#include "runtime/clock.hpp"

namespace slam::guest_serial_test {
namespace {

using namespace std::chrono_literals;

TEST(UsbSerial, OpensByNameSetsDtrAndPassesData) {
  OpenedPort port = openPort("/dev/ttyUSB0", 921600);
  ASSERT_TRUE(port.stream) << port.problem.words();
  EXPECT_EQ(openPort("/dev/ttyUSB0", 921600).problem.words(), "the port is in use by another program");
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

/// As docker run --device=/dev/ttyUSB0:/dev/rplidar gives it: a node of another name, which sysfs does not know.
TEST(UsbSerial, IsSetUpUnderAnyName) {
  struct stat real {};
  ASSERT_EQ(stat("/dev/ttyUSB0", &real), 0);
  const char* const path = "/tmp/rplidar";
  unlink(path);
  ASSERT_EQ(mknod(path, S_IFCHR | 0600, real.st_rdev), 0);
  EXPECT_EQ(ttyNameOf(path), "ttyUSB0");
  for (const int baud : {115200, 256000, 1000000}) {
    OpenedPort port = openPort(path, baud);
    ASSERT_TRUE(port.stream) << port.problem.words();
    EXPECT_TRUE(port.stream->setDtr(true)) << "a pseudo-terminal has none";
    const int fd = open("/dev/ttyUSB0", O_RDONLY | O_NOCTTY | O_NONBLOCK);  // root may, in spite of the lock
    ASSERT_GE(fd, 0);
    struct termios2 mode {};
    EXPECT_EQ(ioctl(fd, TCGETS2, &mode), 0);
    EXPECT_EQ(static_cast<int>(mode.c_ospeed), baud);
    EXPECT_EQ(mode.c_lflag & ICANON, 0U);
    EXPECT_EQ(mode.c_cflag & HUPCL, 0U);
    close(fd);
  }
}

}  // namespace
}  // namespace slam::guest_serial_test
