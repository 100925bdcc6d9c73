// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bus/udpm/udpm_url.hpp"

namespace slam {

/// The socket that datagrams of a multicast group arrive at. It never blocks, and starts no thread. liblcm's own
/// receiver is not used: it puts fragments together by lengths that it does not check, waits 10 s for a message to
/// itself, and stays with the network interface that the route went over at its start.
class MulticastReceiver {
 public:
  enum class Joined : std::uint8_t {
    kAsBefore,
    kAnew,     ///< on the interface that the route goes over now
    kNoRoute,  ///< to the group; where one was joined before, it stays
    kNoSocket  ///< the port is another program's alone, or there are no descriptors left
  };

  explicit MulticastReceiver(const UdpmUrl& url) : url_(url) {}
  ~MulticastReceiver() { close(); }
  MulticastReceiver(const MulticastReceiver&) = delete;
  MulticastReceiver& operator=(const MulticastReceiver&) = delete;

  /// Joins the group on the interface that the route goes over, if it is not yet; leaves the one before. Opens what is
  /// closed. One system call where nothing has changed: ask once a second.
  Joined join();
  void close();

  /// For poll(); -1 while closed.
  int descriptor() const { return socket_; }
  /// The next datagram that waits, if there is one. @return good until the next call
  std::optional<std::span<const std::uint8_t>> next();
  /// Who sent that datagram: the IPv4 address, and in the lower 16 bits the port. Each program sends from a port of its
  /// own.
  std::uint64_t sender() const { return sender_; }
  /// Datagrams that the kernel had no room for.
  std::uint64_t dropped() const { return dropped_; }

 private:
  Joined open();

  const UdpmUrl url_;
  int socket_ = -1;
  std::uint32_t overflow_ = 0;  // the socket's own count of them
  std::uint64_t dropped_ = 0, sender_ = 0;
  std::vector<std::uint8_t> buffer_ = std::vector<std::uint8_t>(65536);  // more than IPv4 can carry
};

}  // namespace slam
