// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/web/access/certificate.hpp"

namespace slam {

struct TlsLimits {
  std::size_t most = 128;                        ///< connections; then the oldest of the address that has most goes
  Duration handshake = std::chrono::seconds(5);  ///< from the connection to its end
  Duration patience = std::chrono::seconds(10);  ///< with one who takes nothing of what is left
  std::size_t buffer = 64 * 1024;                ///< [bytes] in each direction
};

/// Ends TLS in front of a server that knows nothing of it: OpenSSL decrypts in a thread of its own, and the server gets
/// one end of a socket pair in place of the connection. A connection that begins without TLS is passed on as it is.
class TlsFront {
 public:
  /// A socket with plain bytes, for the server to own. @param is_tls whether it came by TLS
  using Take = std::function<void(int socket, std::string address, bool is_tls)>;

  TlsFront(TlsContext context, Take take, const TlsLimits& limits = {});
  ~TlsFront();
  TlsFront(const TlsFront&) = delete;
  TlsFront& operator=(const TlsFront&) = delete;

  /// Owns the socket from now on.
  void add(int socket, std::string address);
  std::size_t connections() const;
  std::uint64_t dropped() const { return dropped_; }  ///< no handshake, took nothing, or made place

 private:
  struct Connection;
  void run();
  void wait();
  /// @return false: it has ended
  bool serve(Connection& connection, Timestamp now);
  bool greet(Connection& connection, Timestamp now);
  bool pump(Connection& connection, Timestamp now);

  const TlsContext context_;
  const Take take_;
  const TlsLimits limits_;
  const int wake_;
  mutable std::mutex mutex_;                              // of the connections
  std::vector<std::unique_ptr<Connection>> connections_;  // the oldest first
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace slam
