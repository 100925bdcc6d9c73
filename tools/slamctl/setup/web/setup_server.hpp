// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <thread>

#include "config/config.hpp"
#include "tools/slamctl/setup/web/web_console.hpp"
#include "tools/web/access/host_guard.hpp"
#include "tools/web/access/token_gate.hpp"
#include "tools/web/http_server.hpp"

namespace slam {

/// Serves the page of a set-up, and for who has its token what a WebConsole shows and asks, while it lives. What it
/// keeps off is as of slam-web.
class SetupServer : public HttpServer {
 public:
  static constexpr const char *kState = "/api/v1/setup", *kAnswer = "/api/v1/setup/answer", *kDrive = "/api/v1/drive";

  /// @param web where it listens, with the token of this set-up @param tls empty: plain http
  /// @throws std::runtime_error where it cannot listen
  SetupServer(const WebConfig& web, WebConsole& console, const HttpConnection::Limits& limits = {},
              TlsContext tls = {});
  ~SetupServer() override;

 private:
  httplib::Server::HandlerResponse route(const httplib::Request& request, httplib::Response& response) const;
  std::string pictureAt(const std::string& path) const;
  void answerQuestion(const httplib::Request& request, httplib::Response& response);

  const WebConfig web_;
  WebConsole& console_;
  const HostGuard hosts_;
  const TokenGate gate_;
  std::thread thread_;
};

}  // namespace slam
