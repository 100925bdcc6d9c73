// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

#include "bus/udpm/packet_dispatcher.hpp"
#include "core/timestamp.hpp"
#include "problems/daemon.hpp"

namespace slam {

/// A Unix socket (SOCK_SEQPACKET) of this machine, on which slamd takes commands and answers them. Each packet is one
/// message as LCM sends it over UDP. Who may open the file may command: owner and group. No call waits, whatever the
/// clients do; there are at most kMostClients of them: where one comes too many, the one that has been silent for
/// longest makes place. One that does not read is dropped.
class LocalSocket {
 public:
  using Client = std::uint64_t;  ///< a connection; no number is used twice
  using Handler = std::function<void(Client from, std::span<const std::uint8_t> message)>;
  struct Counts {
    std::uint64_t bad = 0;      ///< packets that are no message
    std::uint64_t dropped = 0;  ///< clients that did not read
    std::uint64_t refused = 0;  ///< clients that found no place, or gave theirs to a newer one
  };
  static constexpr std::size_t kMostClients = 16;
  static constexpr std::size_t kLongestPath = 107;  ///< [bytes] as the kernel takes it

  /// @param path of the socket's file; empty: there is none, and every call does nothing
  explicit LocalSocket(std::string path);
  ~LocalSocket();
  LocalSocket(const LocalSocket&) = delete;
  LocalSocket& operator=(const LocalSocket&) = delete;

  void subscribe(const std::string& channel, Handler handler);
  /// Opens what is closed, once a second, and looks whether the file is still there. Belongs into each turn of a loop.
  void tend(Timestamp now);
  /// To wait for; -1 without a socket.
  int descriptor() const { return poll_; }
  /// Takes clients and packets that wait, but no more than a queue's worth.
  void receive();
  /// @return false when the client has gone, or is dropped for not reading
  bool send(Client client, const std::string& channel, std::span<const std::uint8_t> data);
  void sendAll(const std::string& channel, std::span<const std::uint8_t> data);

  const std::string& path() const { return path_; }
  /// Why nobody can connect.
  const Problem& problem() const { return problem_; }
  std::size_t clients() const { return clients_.size(); }
  Counts counts() const;

 private:
  struct Connection {
    Client id;
    int socket;
    bool has_asked = false;  // sent a packet, ever
  };

  /// @return what keeps it closed; none: it is open
  Problem open();
  Problem bindFile();
  bool hasFile() const;
  void listen();
  void stopListening();
  void accept();
  void take(Client client);
  bool sendPacket(int socket);
  void drop(Client client);

  const std::string path_;
  const std::optional<gid_t> group_;  // whose members may connect
  int poll_ = -1, listener_ = -1;
  std::pair<dev_t, ino_t> file_{};  // of the socket, to know it from one that took its place
  Problem problem_;
  Timestamp next_look_{};
  std::vector<Connection> clients_;  // in the order of their last packets, or of their coming
  Client next_client_ = 1, sender_ = 0;
  PacketDispatcher dispatcher_;
  Counts counts_;
  std::vector<std::uint8_t> received_ = std::vector<std::uint8_t>(65536), packet_;
};

}  // namespace slam
