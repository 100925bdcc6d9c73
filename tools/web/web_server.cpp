// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_server.hpp"

#include <mutex>
#include <utility>

#include "runtime/clock.hpp"
#include "tools/web/foxglove/upgrade.hpp"

namespace slam {
namespace {

constexpr std::size_t kLongestBody = 4096;  // [bytes] of a command

thread_local Successor successor = Successor::kNone;  // of the request of this thread

}  // namespace

WebServer::WebServer(const WebPages& pages, const SharedState& shared, const EventFeed& feed, const Hubs& hubs,
                     const HttpConnection::Limits& limits, TlsContext tls)
    : HttpServer(limits, std::move(tls)),
      greeting_([&shared, &feed](Timestamp now) {
        const std::lock_guard lock(shared.mutex);
        return feed.greeting(shared.state, now);
      }),
      hubs_(hubs) {
  setRoutes(*this, pages, [](Successor of) { successor = of; });
  const WebConfig& web = pages.settings().web;
  listenOn(web.address, web.port, "change web.address or web.port, or stop the program that listens there");
}

void setRoutes(httplib::Server& server, const WebPages& pages, std::function<void(Successor)> handOver) {
  using Handling = httplib::Server::HandlerResponse;
  server.set_payload_max_length(kLongestBody);
  server.set_default_headers(WebPages::headers());
  server.set_pre_routing_handler([&pages, handOver](const httplib::Request& request, httplib::Response& response) {
    if (!pages.mayEnter(request, response)) return Handling::Handled;
    if (redirectsToTls(request, response)) return Handling::Handled;
    if (isUpgrade(request)) {
      if (pages.mayStream(request, response)) handOver(Successor::kFoxglove);
      return Handling::Handled;
    }
    const std::string path = WebPages::apiPathOf(request.path);
    if (request.method == "POST" && (path == WebPages::kCommand || path == WebPages::kDrive))
      return Handling::Unhandled;
    if (request.method != "GET" || path != WebPages::kEvents) {
      pages.answer(request, response);
    } else if (pages.mayRead(request, response)) {
      response.status = 200;
      response.set_content_provider("text/event-stream", [handOver](std::size_t, httplib::DataSink&) {
        handOver(Successor::kEvents);
        return false;  // somebody else writes what comes behind the head
      });
    }
    return Handling::Handled;
  });
  server.Post("/api/(?:v1/)?command", [&pages](const httplib::Request& request, httplib::Response& response) {
    pages.command(request, response);
  });
  server.Post("/api/(?:v1/)?drive", [&pages](const httplib::Request& request, httplib::Response& response) {
    pages.drive(request, response);
  });
  server.set_post_routing_handler(
      [](const httplib::Request&, httplib::Response& response) { finishUpgrade(response); });
  server.set_exception_handler([](const httplib::Request&, httplib::Response& response, std::exception_ptr) {
    response.status = 500;
    response.set_content("slam-web could not answer this\n", "text/plain");
  });
}

void WebServer::begin() { successor = Successor::kNone; }

bool WebServer::handOver(const ConnectionRoom::Connection& from, HttpConnection& connection) {
  if (successor == Successor::kFoxglove) hubs_.foxglove.add(from.socket, from.address, connection.rest());
  if (successor == Successor::kEvents) {
    const Timestamp now = monotonicNow();
    hubs_.events.add(from.socket, greeting_(now), now, from.address);
  }
  return successor != Successor::kNone;
}

}  // namespace slam
