// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/http_server.hpp"

#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "runtime/clock.hpp"
#include "tools/web/page_files.hpp"

namespace slam {
namespace {

constexpr int kPermanentRedirect = 308;  // with the same method and body
constexpr int kSendBuffer = 128 * 1024;  // [bytes] a reader that sleeps holds no more of the kernel's memory

thread_local bool redirects = false;  // the request of this thread came by http, not https

}  // namespace

/// Takes the place of cpp-httplib's pool, which gives a thread to each connection, whether it asks for anything or not,
/// and keeps any number of them.
class HttpServer::Requests : public httplib::TaskQueue {
 public:
  Requests(HttpServer& server, TlsContext tls)
      : server_(server),
        room_({.request = server.limits_.request, .request_size = server.limits_.request_size}),
        watcher_([this] { watch(); }) {
    if (!tls.context) return;
    tls_ = std::make_unique<TlsFront>(std::move(tls), [this](int socket, std::string address, bool is_tls) {
      room_.add(socket, std::move(address), monotonicNow(), !is_tls);
    });
  }

  /// In the thread that accepts.
  void enqueue(std::function<void()> connection) override { connection(); }
  void shutdown() override {
    ending_ = true;
    tls_.reset();
    watcher_.join();
    pool_.shutdown();
  }

  void take(int socket) {
    tls_ ? tls_->add(socket, addressOf(socket)) : room_.add(socket, addressOf(socket), monotonicNow());
  }
  /// Whether requests wait for a thread.
  bool isCrowded() const { return waiting_ > 0; }

 private:
  void watch() {
    constexpr std::chrono::milliseconds kLook{50};  // for those that have had too much time
    while (!ending_) {
      room_.wait(kLook);
      for (ConnectionRoom::Connection& connection : room_.takeReady(monotonicNow())) pass(std::move(connection));
    }
  }
  void pass(ConnectionRoom::Connection connection) {
    {
      const std::lock_guard lock(mutex_);
      std::size_t& own = passed_[connection.address];
      if (waiting_ >= kMostWaiting || own >= kMostOfOne) return refuse(connection.socket);
      ++own;
    }
    ++waiting_;
    pool_.enqueue([this, connection = std::move(connection)] {
      --waiting_;
      server_.answer(connection);
      const std::lock_guard lock(mutex_);
      if (--passed_[connection.address] == 0) passed_.erase(connection.address);
    });
  }
  static void refuse(int socket) {
    constexpr std::string_view kBusy =
        "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
    ::send(socket, kBusy.data(), kBusy.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    ::close(socket);
  }
  // The rest is there for others.
  static constexpr std::size_t kMostOfOne = (kThreads + kMostWaiting) * 3 / 4;

  HttpServer& server_;
  ConnectionRoom room_;
  std::unique_ptr<TlsFront> tls_;
  std::atomic<std::size_t> waiting_{0};
  std::mutex mutex_;
  std::map<std::string, std::size_t> passed_;  // requests of each address that wait for a thread or have one
  httplib::ThreadPool pool_{kThreads};
  std::atomic<bool> ending_{false};
  std::thread watcher_;
};

HttpServer::HttpServer(const HttpConnection::Limits& limits, TlsContext tls) : limits_(limits) {
  const auto context = std::make_shared<TlsContext>(std::move(tls));
  new_task_queue = [this, context] {
    return requests_ = new Requests(*this, std::move(*context));
  };  // cpp-httplib deletes it
  set_tcp_nodelay(true);
  // Without SO_REUSEPORT, which cpp-httplib sets: a second program on the port is refused, not mixed in.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
}

void HttpServer::listenOn(const std::string& address, int port, const std::string& fix) {
  errno = 0;
  port_ = port == 0 ? bind_to_any_port(address) : bind_to_port(address, port) ? port : -1;
  // cpp-httplib lets five wait; the sixth page that asks for a changed tile at the same moment would wait for a second.
  if (port_ > 0 && ::listen(svr_sock_, static_cast<int>(kMostWaiting)) == 0) return;
  throw std::runtime_error("cannot listen on " + address + ":" + std::to_string(port) + ": " +
                           (errno != 0 ? std::strerror(errno) : "no such address here") + "; " + fix);
}

bool redirectsToTls(const httplib::Request& request, httplib::Response& response) {
  if (!redirects) return false;
  const std::string target = request.target.starts_with('/') ? request.target : "/";
  response.set_redirect("https://" + request.get_header_value("Host") + target, kPermanentRedirect);
  return true;
}

void prepareRequest(httplib::Request& request) {
  request.ranges.clear();
  request.headers.erase("Range");
  const bool gzip = request.get_header_value("Accept-Encoding").find("gzip") != std::string::npos;
  request.headers.erase("Accept-Encoding");
  if (gzip && findPageFile(request.path) != nullptr) request.headers.emplace("Accept-Encoding", "gzip");
}

bool HttpServer::process_and_close_socket(socket_t socket) {
  requests_->take(socket);
  return true;
}

void HttpServer::answer(const ConnectionRoom::Connection& from) {
  const int socket = from.socket;
  setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  HttpConnection connection(socket, limits_, from.address, [this] { return requests_->isCrowded(); });
  redirects = from.redirects;
  begin();
  bool closed = false;
  try {
    process_request(connection, true, closed, prepareRequest);
  } catch (const std::exception&) {  // cpp-httplib's parser: the connection ends
  }
  if (handOver(from, connection)) return;
  ::shutdown(socket, SHUT_WR);
  ::close(socket);
}

void HttpServer::run() {
  listen_after_bind();
  ended_ = true;
}

void HttpServer::stop() {
  while (!is_running() && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // else it is not heard
  httplib::Server::stop();
}

}  // namespace slam
