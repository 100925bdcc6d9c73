// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "drivers/byte_stream.hpp"
#include "drivers/virtual_time.hpp"

namespace slam::test {

/// A serial line between a driver and a device of the test, both in virtual time: it passes while the driver waits, and
/// nothing else lets it pass. One thread.
class VirtualLine {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Receive = std::function<void(std::span<const std::uint8_t>)>;
  using Send = std::function<void(Bytes& out)>;

  /// @param receive takes what the driver writes
  /// @param send appends what the device has sent by now; called every millisecond
  VirtualLine(Receive receive, Send send) : receive_(std::move(receive)), send_(std::move(send)) {}

  PortOpener opener() {
    return [this](const std::string&, int) -> OpenedPort {
      if (!plugged_) return {nullptr, problem::kPortMissing};
      return {std::make_unique<Stream>(*this), {}};
    };
  }
  /// Hang-up.
  void unplug() { plugged_ = false; }
  void plug() { plugged_ = true; }
  /// Done every millisecond.
  std::function<void()> meanwhile = [] {};

  void pass(Duration time) {
    constexpr Duration kStep = std::chrono::milliseconds(1);
    for (const Timestamp end = virtual_now + time; virtual_now < end;) {
      virtual_now += std::min<Duration>(kStep, end - virtual_now);
      collect();
      meanwhile();
    }
  }

 private:
  static constexpr std::size_t kBuffer = 4096;  // [bytes] of the kernel's: what does not fit is lost

  class Stream : public ByteStream {
   public:
    explicit Stream(VirtualLine& line) : line_(line) {}
    ReadResult read(std::span<std::uint8_t> out, Duration timeout) override {
      Bytes& arrived = line_.arrived_;
      for (const Timestamp end = virtual_now + timeout;;) {
        if (!line_.plugged_) return {ReadResult::kClosed, 0};
        if (!arrived.empty()) {
          const std::size_t size = std::min(out.size(), arrived.size());
          const auto behind = arrived.begin() + static_cast<std::ptrdiff_t>(size);
          std::copy(arrived.begin(), behind, out.begin());
          arrived.erase(arrived.begin(), behind);
          return {ReadResult::kData, size};
        }
        if (virtual_now >= end) return {};
        line_.pass(std::min<Duration>(std::chrono::milliseconds(1), end - virtual_now));
      }
    }
    void rest(Duration time) override { line_.pass(time); }
    bool write(std::span<const std::uint8_t> bytes) override {
      if (line_.plugged_) line_.receive_(bytes);
      return line_.plugged_;
    }
    void discardInput() override { line_.arrived_.clear(); }
    bool setDtr(bool) override { return false; }

   private:
    VirtualLine& line_;
  };

  void collect() {
    send_(arrived_);
    if (arrived_.size() > kBuffer) arrived_.resize(kBuffer);
  }

  Receive receive_;
  Send send_;
  Bytes arrived_;
  bool plugged_ = true;
};

}  // namespace slam::test
