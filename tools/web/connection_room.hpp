// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam {

/// Connections whose request has not come whole yet. They cost a descriptor each and no thread, so that who is slow to
/// ask keeps nobody waiting. Where the room is full, the oldest one of the address that has most of them makes place.
/// Safe from several threads.
class ConnectionRoom {
 public:
  struct Limits {
    Duration request = std::chrono::seconds(5);  ///< from the connection to the last byte of the request
    std::size_t request_size = 32 * 1024;        ///< [bytes] head and body; more is not waited for
    std::size_t most = 64;                       ///< connections
  };
  struct Connection {
    int socket;
    std::string address;  ///< whom it comes from
    Timestamp since;
    bool ended = false;      ///< the other side sends no more
    bool redirects = false;  ///< it came by http where https is spoken
  };

  explicit ConnectionRoom(const Limits& limits);
  ~ConnectionRoom();
  ConnectionRoom(const ConnectionRoom&) = delete;
  ConnectionRoom& operator=(const ConnectionRoom&) = delete;

  /// Owns the socket from now on.
  void add(int socket, std::string address, Timestamp now, bool redirects = false);
  /// Returns when something has come of any, or after a while.
  void wait(std::chrono::milliseconds limit);
  /// Those whose request is whole, or whose other side will send no more, for the caller to own. Who has had too much
  /// time is refused and closed.
  std::vector<Connection> takeReady(Timestamp now);

  std::size_t size() const;
  std::uint64_t dropped() const;  ///< made place for others, or were too slow

 private:
  void drop(std::size_t index);

  const Limits limits_;
  const int poll_;
  mutable std::mutex mutex_;        // of all below
  std::deque<Connection> waiting_;  // the oldest first
  std::uint64_t dropped_ = 0;
  std::vector<char> seen_ = std::vector<char>(limits_.request_size);
};

/// Whether these bytes are a whole HTTP request, or one that cannot become one. Pure.
bool isWholeRequest(std::string_view bytes);
/// The address of who is at the other end, without port; of IPv6 the network's part, since one user has all of it.
std::string addressOf(int socket);

}  // namespace slam
