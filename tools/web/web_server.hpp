// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <functional>
#include <string>

#include "tools/web/access/tls_front.hpp"
#include "tools/web/connection_room.hpp"
#include "tools/web/event_hub.hpp"
#include "tools/web/foxglove/foxglove_hub.hpp"
#include "tools/web/http_connection.hpp"
#include "tools/web/http_library.hpp"
#include "tools/web/text/event_text.hpp"
#include "tools/web/web_pages.hpp"

namespace slam {

/// Who takes connections over.
struct Hubs {
  EventHub& events;
  FoxgloveHub& foxglove;
};
/// Which of them, once the head of the answer is sent.
enum class Successor : std::uint8_t { kNone, kEvents, kFoxglove };

/// Has a server answer with these pages. @param handOver has the connection of the request being answered handed over
void setRoutes(httplib::Server& server, const WebPages& pages, std::function<void(Successor)> handOver);

/// Takes from a request what is not offered: parts of a file, and compression but of the page's files by gzip. What
/// else there is is small, or compressed already.
void prepareRequest(httplib::Request& request);

/// Listens, and answers with WebPages; who listens to events is handed to the EventHub, and a WebSocket to the
/// FoxgloveHub. A connection has a thread only
/// when its request has come whole, and no longer than it takes what is sent where others wait. Threads, waiting
/// connections, those of one address, and the time and size of a request are bounded. One request for each connection.
class WebServer : private httplib::Server {
 public:
  static constexpr std::size_t kThreads = 16, kMostWaiting = 32;

  /// @throws std::runtime_error where it cannot listen @param tls empty: plain http
  WebServer(const WebPages& pages, const SharedState& shared, const EventFeed& feed, const Hubs& hubs,
            const HttpConnection::Limits& limits = {}, TlsContext tls = {});

  int port() const { return port_; }
  /// Returns after stop().
  void run();
  /// For while run() runs in another thread, or is about to.
  void stop();

 private:
  class Requests;
  bool process_and_close_socket(socket_t socket) override;
  void answer(const ConnectionRoom::Connection& from);
  void handOver(const ConnectionRoom::Connection& from);

  const std::function<std::string(Timestamp now)> greeting_;  // of who listens to events
  const Hubs hubs_;
  const HttpConnection::Limits limits_;
  Requests* requests_ = nullptr;  // of cpp-httplib, while run() runs
  int port_ = 0;
  std::atomic<bool> ended_{false};  // run() has
};

}  // namespace slam
