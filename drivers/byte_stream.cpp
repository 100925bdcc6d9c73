// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/byte_stream.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "drivers/serial_port.hpp"

namespace slam {
namespace {

class DescriptorStream : public ByteStream {
 public:
  explicit DescriptorStream(int descriptor) : descriptor_(descriptor) {}
  ~DescriptorStream() override { close(descriptor_); }

  bool write(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return true;
  }
  void discardInput() override {
    std::array<std::uint8_t, 256> away;
    if (tcflush(descriptor_, TCIFLUSH) == 0) return;
    while (take(away) > 0) {
    }
  }
  bool setDtr(bool) override { return false; }

 protected:
  int descriptor() const override { return descriptor_; }
  int take(std::span<std::uint8_t> out) override {
    const ssize_t n = ::read(descriptor_, out.data(), out.size());
    if (n > 0) return static_cast<int>(n);
    return n < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
  }

 private:
  int descriptor_;
};

timespec timespecOf(Duration time) {
  return {static_cast<time_t>(time.count() / 1000000000), static_cast<long>(time.count() % 1000000000)};
}

}  // namespace

ReadResult ByteStream::read(std::span<std::uint8_t> out, Duration timeout) {
  pollfd waiting{descriptor(), POLLIN, 0};
  const timespec limit = timespecOf(timeout);
  const int ready = ppoll(&waiting, 1, &limit, nullptr);
  if (ready < 0) return {errno == EINTR ? ReadResult::kTimeout : ReadResult::kClosed, 0};
  if (ready == 0) return {};
  const int n = take(out);
  if (n > 0) return {ReadResult::kData, static_cast<std::size_t>(n)};
  // Readable but empty, or hung up: the device is gone. Waiting on it again would return at once, for ever.
  const bool gone = n < 0 || (waiting.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
  return {gone ? ReadResult::kClosed : ReadResult::kTimeout, 0};
}

void ByteStream::rest(Duration time) {
  const timespec limit = timespecOf(time);
  ppoll(nullptr, 0, &limit, nullptr);
}

bool lockPort(int descriptor) {
  ioctl(descriptor, TIOCEXCL);  // keeps others out, but not root
  return flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

std::unique_ptr<ByteStream> makeDescriptorStream(int descriptor) {
  fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  return std::make_unique<DescriptorStream>(descriptor);
}

OpenedPort openPort(const std::string& path, int baud) {
  if (isSerialPort(path)) return openSerialPort(path, baud);

  const int fd = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    if (errno == ENOENT || errno == ENODEV || errno == ENXIO)
      return {nullptr, "no such port: check cable and udev rule"};
    if (errno == EACCES) return {nullptr, "no right to open the port: add the user to group dialout"};
    return {nullptr, "the port cannot be opened"};
  }
  auto stream = makeDescriptorStream(fd);
  termios mode{};
  if (tcgetattr(fd, &mode) != 0) return {nullptr, "not a serial port: check the path"};
  if (!lockPort(fd)) return {nullptr, "the port is in use by another program"};
  cfmakeraw(&mode);
  mode.c_cflag |= CLOCAL | CREAD;
  tcsetattr(fd, TCSANOW, &mode);
  return {std::move(stream), ""};
}

}  // namespace slam
