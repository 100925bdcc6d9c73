// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <poll.h>
#include <span>
#include <stdexcept>
#include <stdlib.h>  // NOLINT: posix_openpt
#include <string>
#include <sys/ioctl.h>
#include <termios.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include "drivers/byte_stream.hpp"
#include "runtime/clock.hpp"

namespace slam::test {

using Bytes = std::vector<std::uint8_t>;

/// The device's end of a raw pseudo-terminal, held behind a link as udev does, so that a device can be plugged in again
/// under the same name.
class PseudoTerminal {
 public:
  PseudoTerminal() {
    static int count = 0;
    link_ = std::filesystem::temp_directory_path() /
            ("slamd_pty_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    plug();
  }
  ~PseudoTerminal() {
    unplug();
    std::filesystem::remove(link_);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  const std::string& path() const { return link_; }
  bool plugged() const { return master_ >= 0; }

  void plug() {
    unplug();
    *sent_ = 0;
    master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0) throw std::runtime_error("no pseudo-terminal");
    const std::string slave = ptsname(master_);
    keeper_ = open(slave.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // keeps the line up while nobody has it open
    termios settings{};
    tcgetattr(keeper_, &settings);
    cfmakeraw(&settings);
    tcsetattr(keeper_, TCSANOW, &settings);
    std::filesystem::remove(link_);
    std::filesystem::create_symlink(slave, link_);
  }
  /// What a pulled cable is to the computer: hang-up, and no such device.
  void unplug() {
    if (master_ < 0) return;
    close(keeper_);
    close(master_);
    master_ = keeper_ = -1;
    std::filesystem::remove(link_);
  }

  /// How a driver opens the other end where received() is to wait for what it writes.
  PortOpener opener() {
    return [sent = sent_](const std::string& path, int baud) {
      OpenedPort port = openPort(path, baud);
      if (port.stream) port.stream = std::make_unique<CountedStream>(std::move(port.stream), sent);
      return port;
    };
  }
  /// All that was written through opener() and not received yet, however late the kernel passes it on.
  Bytes received() {
    Bytes all;
    const auto limit = std::chrono::steady_clock::now() + kLatest;
    do {
      const Bytes more = read(all.size() < *sent_ ? std::chrono::milliseconds(10) : Duration(0));
      all.insert(all.end(), more.begin(), more.end());
    } while (all.size() < *sent_ && std::chrono::steady_clock::now() < limit);
    *sent_ -= std::min(*sent_, all.size());
    return all;
  }

  /// Bytes that arrive within `timeout`, empty if none.
  Bytes read(Duration timeout) {
    Bytes bytes(4096);
    pollfd descriptor{master_, POLLIN, 0};
    const timespec limit{timeout.count() / 1'000'000'000, timeout.count() % 1'000'000'000};
    const ssize_t size = ppoll(&descriptor, 1, &limit, nullptr) == 1 ? ::read(master_, bytes.data(), bytes.size()) : 0;
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return bytes;
  }
  /// For an other end that reads meanwhile. @return bytes that found room
  int send(std::span<const std::uint8_t> bytes) {
    return static_cast<int>(std::max<ssize_t>(0, ::write(master_, bytes.data(), bytes.size())));
  }
  /// Returns when the other end can read it, which must not read meanwhile: the kernel passes bytes on in a thread of
  /// its own, and not all of them at once. Drops what does not fit, as a UART does.
  void write(std::span<const std::uint8_t> bytes) {
    if (master_ < 0) return;
    const int before = readable(), written = send(bytes);
    const auto limit = std::chrono::steady_clock::now() + kLatest;
    while (readable() < std::min(before + written, kBuffer) && std::chrono::steady_clock::now() < limit)
      std::this_thread::yield();
  }

 private:
  static constexpr int kBuffer = 4095;               // bytes that the line keeps for its reader
  static constexpr std::chrono::seconds kLatest{2};  // that the kernel of a busy machine passes bytes on

  class CountedStream : public ByteStream {
   public:
    CountedStream(std::unique_ptr<ByteStream> inner, std::shared_ptr<std::size_t> sent)
        : inner_(std::move(inner)), sent_(std::move(sent)) {}
    ReadResult read(std::span<std::uint8_t> out, Duration timeout) override { return inner_->read(out, timeout); }
    bool write(std::span<const std::uint8_t> bytes) override {
      const bool written = inner_->write(bytes);
      if (written) *sent_ += bytes.size();
      return written;
    }
    void discardInput() override { inner_->discardInput(); }
    bool setDtr(bool on) override { return inner_->setDtr(on); }

   private:
    std::unique_ptr<ByteStream> inner_;
    std::shared_ptr<std::size_t> sent_;  // [bytes]
  };

  /// Bytes that wait for the reader.
  int readable() const {
    int bytes = 0;
    return ioctl(keeper_, FIONREAD, &bytes) == 0 ? bytes : 0;
  }

  std::string link_;
  std::shared_ptr<std::size_t> sent_ = std::make_shared<std::size_t>(0);  // [bytes] not received yet
  int master_ = -1, keeper_ = -1;
};

}  // namespace slam::test
