// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "core/timestamp.hpp"

namespace slam {

/// The sockets of all who listen to the stream of events. Sends to each what fits without waiting, and lets go of who
/// does not read: a reader costs no thread, and bounded memory.
class EventHub {
 public:
  static constexpr std::size_t kMostReaders = 32;
  static constexpr std::size_t kMostUnsent = 512 * 1024;           ///< [bytes] for a reader; a long trail is 60 kB
  static constexpr Duration kPatience = std::chrono::seconds(10);  ///< with a reader that takes nothing

  EventHub() = default;
  ~EventHub();
  EventHub(const EventHub&) = delete;
  EventHub& operator=(const EventHub&) = delete;

  /// Owns the socket from now on. Where one comes too many, the oldest one of the address that has most makes place.
  /// @param greeting goes to it first @param address whom it comes from
  void add(int socket, std::string greeting, Timestamp now, std::string address = "");
  void send(const std::string& text, Timestamp now);
  std::size_t readers() const;
  std::uint64_t dropped() const;  ///< who did not read, or made place

 private:
  struct Reader {
    int socket;
    std::string unsent;
    Timestamp progress;
    std::string address;
  };
  void makePlace();
  /// @return false for a reader that is gone or too slow
  bool push(Reader& reader, Timestamp now);

  mutable std::mutex mutex_;
  std::vector<Reader> readers_;  // the oldest first
  std::uint64_t dropped_ = 0;
};

}  // namespace slam
