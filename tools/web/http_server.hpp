// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <string>

#include "tools/web/access/tls_front.hpp"
#include "tools/web/connection_room.hpp"
#include "tools/web/http_connection.hpp"
#include "tools/web/http_library.hpp"

namespace slam {

/// Takes from a request what is not offered: parts of a file, and compression but of the page's files by gzip. What
/// else there is is small, or compressed already.
void prepareRequest(httplib::Request& request);

/// For who answers a request: whether it came by http where https is spoken, and is answered by that.
bool redirectsToTls(const httplib::Request& request, httplib::Response& response);

/// Listens. A connection has a thread only when its request has come whole, and no longer than it takes what is sent
/// where others wait. Threads, waiting connections, those of one address, and the time and size of a request are
/// bounded. One request for each connection. Who derives from it sets the routes.
class HttpServer : protected httplib::Server {
 public:
  static constexpr std::size_t kThreads = 16, kMostWaiting = 32;

  int port() const { return port_; }
  /// Returns after stop().
  void run();
  /// For while run() runs in another thread, or is about to.
  void stop();

 protected:
  /// @param tls empty: plain http
  HttpServer(const HttpConnection::Limits& limits, TlsContext tls);

  /// @param port 0: any that is free @param fix what helps @throws std::runtime_error where it cannot listen
  void listenOn(const std::string& address, int port, const std::string& fix);

 private:
  class Requests;
  /// Before a request, in its thread.
  virtual void begin() {}
  /// Behind the answer to it. @return whether somebody else has the connection now
  virtual bool handOver(const ConnectionRoom::Connection&, HttpConnection&) { return false; }
  bool process_and_close_socket(socket_t socket) override;
  void answer(const ConnectionRoom::Connection& from);

  const HttpConnection::Limits limits_;
  Requests* requests_ = nullptr;  // of cpp-httplib, while run() runs
  int port_ = 0;
  std::atomic<bool> ended_{false};  // run() has
};

}  // namespace slam
