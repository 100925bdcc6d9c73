// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/pseudo_terminal.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <system_error>
#include <termios.h>
#include <unistd.h>

namespace slam::sim {
namespace {

[[noreturn]] void fail(const std::string& what) { throw std::system_error(errno, std::generic_category(), what); }

}  // namespace

PseudoTerminal::PseudoTerminal(const std::filesystem::path& link) : link_(link) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master < 0) fail("posix_openpt");
  stream_ = makeDescriptorStream(master);
  if (!stream_) fail("epoll");
  std::array<char, 128> name{};
  if (grantpt(master) != 0 || unlockpt(master) != 0 || ptsname_r(master, name.data(), name.size()) != 0) fail("pty");
  slave_ = open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (slave_ < 0) fail(name.data());
  termios mode{};
  tcgetattr(slave_, &mode);
  cfmakeraw(&mode);
  tcsetattr(slave_, TCSANOW, &mode);
  std::filesystem::create_directories(link.parent_path());
  std::filesystem::remove(link);
  std::filesystem::create_symlink(name.data(), link);
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code error;
  std::filesystem::remove(link_, error);
  close(slave_);
}

ByteStream& PseudoTerminal::stream() {
  // A real port forgets at its last close that it was one program's alone. This one is never closed: a driver that was
  // killed would keep the next one out, unless that is root's.
  ioctl(slave_, TIOCNXCL);
  return *stream_;
}

void PseudoTerminal::send(std::span<const std::uint8_t> bytes) { stream_->write(bytes); }

}  // namespace slam::sim
