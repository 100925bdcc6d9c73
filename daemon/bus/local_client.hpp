// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <sys/types.h>
#include <sys/un.h>
#include <vector>

namespace slam {

/// @return false for a path that is too long
bool toAddress(const std::string& path, sockaddr_un& address);

/// The other side of a LocalSocket.
class LocalClient {
 public:
  static constexpr const char* kGroup = "slamd";  ///< whose members may command

  LocalClient() = default;
  ~LocalClient() { close(); }
  LocalClient(const LocalClient&) = delete;
  LocalClient& operator=(const LocalClient&) = delete;

  /// Does not wait. @return 0, or the error: ENOENT: there is no such socket; ECONNREFUSED: nobody listens any more;
  /// EACCES: no right; EAGAIN: too many wait already; ENOTSOCK: another kind of file
  int open(const std::string& path);
  /// The same, and lets go at once.
  static int probe(const std::string& path) { return LocalClient().open(path); }
  void close();

  bool isOpen() const { return socket_ >= 0; }
  /// Number of the process that listens.
  std::optional<pid_t> peer() const;
  bool send(const std::string& channel, std::span<const std::uint8_t> data);
  /// The next packet, if one comes in time; closes when the other side has. @return good until the next call; empty
  /// where it was larger than any message
  std::optional<std::span<const std::uint8_t>> next(std::chrono::milliseconds wait);

 private:
  int socket_ = -1;
  std::vector<std::uint8_t> received_ = std::vector<std::uint8_t>(65536), packet_;
};

}  // namespace slam
