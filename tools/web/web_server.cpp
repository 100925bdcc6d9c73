// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_server.hpp"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr std::size_t kLongestBody = 4096;  // [bytes] of a command
constexpr int kSendBuffer = 128 * 1024;     // [bytes] a reader that sleeps holds no more of the kernel's memory

thread_local bool refusing = false;    // the accepting thread: there is no room for this connection
thread_local bool hands_over = false;  // the request of this thread was for the stream of events

/// cpp-httplib's own pool takes any number of connections, each with its descriptor.
class BoundedPool : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> work) override {
    if (waiting_ >= WebServer::kMostWaiting) {
      refusing = true;
      work();
      refusing = false;
      return;
    }
    ++waiting_;
    pool_.enqueue([this, work = std::move(work)] {
      --waiting_;
      work();
    });
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  std::atomic<std::size_t> waiting_{0};
  httplib::ThreadPool pool_{WebServer::kThreads};
};

}  // namespace

WebServer::WebServer(const WebPages& pages, const SharedState& shared, const EventFeed& feed, EventHub& hub,
                     const HttpConnection::Limits& limits)
    : shared_(shared), feed_(feed), hub_(hub), limits_(limits) {
  new_task_queue = [] { return new BoundedPool; };
  setRoutes(
      *this, pages, [&hub] { return hub.hasRoom(); }, [] { hands_over = true; });
  set_tcp_nodelay(true);
  // Without SO_REUSEPORT, which cpp-httplib sets: a second program on the port is refused, not mixed in.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  const WebConfig& web = pages.settings().web;
  errno = 0;
  port_ = web.port == 0 ? bind_to_any_port(web.address) : bind_to_port(web.address, web.port) ? web.port : -1;
  // cpp-httplib lets five wait; the sixth page that asks for a changed tile at the same moment would wait for a second.
  if (port_ > 0 && ::listen(svr_sock_, static_cast<int>(kMostWaiting)) == 0) return;
  throw std::runtime_error("cannot listen on " + web.address + ":" + std::to_string(web.port) + ": " +
                           (errno != 0 ? std::strerror(errno) : "no such address here") +
                           "; change web.address or web.port, or stop the program that listens there");
}

void setRoutes(httplib::Server& server, const WebPages& pages, std::function<bool()> hasRoom,
               std::function<void()> takeReader) {
  using Handling = httplib::Server::HandlerResponse;
  server.set_payload_max_length(kLongestBody);
  server.set_default_headers(WebPages::headers());
  server.set_pre_routing_handler(
      [&pages, hasRoom, takeReader](const httplib::Request& request, httplib::Response& response) {
        if (!pages.mayEnter(request, response)) return Handling::Handled;
        if (request.method == "POST" && request.path == WebPages::kCommand) return Handling::Unhandled;
        if (request.method != "GET" || request.path != WebPages::kEvents) {
          pages.answer(request, response);
        } else if (!hasRoom()) {
          response.status = 503;
          response.set_content("too many pages are open on this robot; close one\n", "text/plain");
        } else {
          response.status = 200;
          response.set_content_provider("text/event-stream", [takeReader](std::size_t, httplib::DataSink&) {
            takeReader();
            return false;  // somebody else writes what comes behind the head
          });
        }
        return Handling::Handled;
      });
  server.Post(WebPages::kCommand, [&pages](const httplib::Request& request, httplib::Response& response) {
    pages.command(request, response);
  });
  server.set_exception_handler([](const httplib::Request&, httplib::Response& response, std::exception_ptr) {
    response.status = 500;
    response.set_content("slam-web could not answer this\n", "text/plain");
  });
}

void prepareRequest(httplib::Request& request) {
  request.ranges.clear();
  request.headers.erase("Range");
  request.headers.erase("Accept-Encoding");
}

bool WebServer::process_and_close_socket(socket_t socket) {
  if (refusing) {
    constexpr char kBusy[] = "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
    ::send(socket, kBusy, sizeof kBusy - 1, MSG_DONTWAIT | MSG_NOSIGNAL);
    ::close(socket);
    return false;
  }
  setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  HttpConnection connection(socket, limits_);
  hands_over = false;
  bool closed = false;
  try {
    process_request(connection, true, closed, prepareRequest);
  } catch (const std::exception&) {  // cpp-httplib's parser: the connection ends
  }
  if (hands_over) {
    handOver(socket);
    return true;
  }
  ::shutdown(socket, SHUT_WR);
  ::close(socket);
  return true;
}

void WebServer::handOver(int socket) {
  const Timestamp now = monotonicNow();
  std::string greeting;
  {
    const std::lock_guard lock(shared_.mutex);
    greeting = feed_.greeting(shared_.state, now);
  }
  hub_.add(socket, std::move(greeting), now);
}

void WebServer::run() {
  listen_after_bind();
  ended_ = true;
}

void WebServer::stop() {
  while (!is_running() && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // else it is not heard
  httplib::Server::stop();
}

}  // namespace slam
