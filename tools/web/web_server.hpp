// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>

#include "tools/web/event_hub.hpp"
#include "tools/web/foxglove/foxglove_hub.hpp"
#include "tools/web/http_server.hpp"
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

/// Answers with WebPages; who listens to events is handed to the EventHub, and a WebSocket to the FoxgloveHub.
class WebServer : public HttpServer {
 public:
  /// @throws std::runtime_error where it cannot listen @param tls empty: plain http
  WebServer(const WebPages& pages, const SharedState& shared, const EventFeed& feed, const Hubs& hubs,
            const HttpConnection::Limits& limits = {}, TlsContext tls = {});

 private:
  void begin() override;
  bool handOver(const ConnectionRoom::Connection& from, HttpConnection& connection) override;

  const std::function<std::string(Timestamp now)> greeting_;  // of who listens to events
  const Hubs hubs_;
};

}  // namespace slam
