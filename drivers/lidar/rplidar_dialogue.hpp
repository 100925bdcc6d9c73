// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "drivers/byte_stream.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "drivers/lidar/rplidar_scan_stream.hpp"
#include "drivers/lidar/text_watch.hpp"

namespace slam::rplidar {

/// Requests and answers with a unit at the other end of a line that may still carry bytes of an old scan. For the times
/// before and after a scan: it may allocate.
class Dialogue {
 public:
  using Clock = Timestamp (*)();

  Dialogue(ByteStream& stream, Clock now, const std::atomic<bool>* cancel)
      : stream_(stream), now_(now), cancel_(cancel) {}

  bool send(std::span<const std::uint8_t> bytes) { return stream_.write(bytes); }
  /// Sends a request and waits for the answer of that type.
  /// @param size [bytes] of the answer; 0: any. @return empty when it did not come
  std::vector<std::uint8_t> ask(std::span<const std::uint8_t> request, AnswerType type, std::size_t size,
                                Duration timeout);
  /// Waits for the announcement of a stream. Bytes behind it stay in takeInput().
  std::optional<Descriptor> awaitStream(Duration timeout);
  /// Reads away what comes, until nothing has come for `silence`.
  void drain(Duration silence, Duration limit);
  /// After a reset: waits for the end of the boot banner. @return false when it did not come
  bool awaitBoot(Duration timeout);

  /// One read. @return what came, with what was read ahead of it
  std::vector<std::uint8_t> readOn(Duration timeout) {
    read(timeout);
    return takeInput();
  }

  bool hungUp() const { return hung_up_; }
  bool receivedBytes() const { return bytes_; }                     ///< any, since construction
  std::span<const std::uint8_t> recent() const { return recent_; }  ///< the last bytes that came, up to 2 kB
  bool sawBoot() const { return saw_boot_; }                        ///< a boot banner, since construction
  bool cancelled() const { return cancel_ != nullptr && *cancel_; }
  std::vector<std::uint8_t> takeInput() { return std::exchange(input_, {}); }

 private:
  bool read(Duration timeout);
  template <typename Accept>
  std::optional<Descriptor> awaitDescriptor(Timestamp end, const Accept& accept);

  ByteStream& stream_;
  Clock now_;
  const std::atomic<bool>* cancel_;
  std::vector<std::uint8_t> input_;  // read ahead of a descriptor or answer
  std::vector<std::uint8_t> recent_;
  TextWatch boot_text_{kBootText}, boot_end_text_{kBootEndText};
  bool hung_up_ = false, bytes_ = false, saw_boot_ = false, saw_boot_end_ = false;
};

}  // namespace slam::rplidar
