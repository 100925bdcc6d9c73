// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "drivers/byte_stream.hpp"
#include "drivers/retry.hpp"

namespace slam {

/// A serial port that a thread looks after at a fixed rate without ever waiting for bytes: opened when it is there, and
/// again when it was lost, less and less often.
class PolledPort {
 public:
  PolledPort(std::string path, int baud) : path_(std::move(path)), baud_(baud) {}

  bool isOpen() const { return stream_ != nullptr; }
  /// While it is not open: whether to try now.
  bool due(Timestamp now) const { return retry_.due(now); }
  /// Opens it and forgets what had come before. @return what is in the way, static text; empty when it is open
  const char* open(Timestamp now) {
    OpenedPort port = openPort(path_, baud_);
    if (!port.stream) {
      retry_.failed(now);
      return port.problem;
    }
    stream_ = std::move(port.stream);
    stream_->discardInput();
    return "";
  }
  /// It failed: the next attempt waits.
  void fail(Timestamp now) {
    close();
    retry_.failed(now);
  }
  /// What comes makes sense: the next attempt after a failure is soon again.
  void succeeded() { retry_.succeeded(); }
  void close() { stream_.reset(); }

  /// Hands over the bytes that have come, one by one, as many as a tick may take.
  /// @return false when the port has hung up
  template <typename Take>
  bool drain(Take&& take) {
    std::array<std::uint8_t, 512> chunk;
    for (std::size_t taken = 0; taken < kMostBytes;) {
      const ReadResult result = stream_->read(chunk, Duration(0));
      if (result.status == ReadResult::kClosed) return false;
      if (result.status == ReadResult::kTimeout) break;
      taken += result.size;
      for (std::size_t i = 0; i < result.size; ++i) take(chunk[i]);
    }
    return true;
  }
  void write(std::span<const std::uint8_t> bytes) { stream_->write(bytes); }

 private:
  static constexpr std::size_t kMostBytes = 16384;  // a tick: at 921600 bit/s one of 200 Hz brings 461
  std::string path_;
  int baud_;  // [bit/s]
  std::unique_ptr<ByteStream> stream_;
  Retry retry_{std::chrono::milliseconds(200)};
};

}  // namespace slam
