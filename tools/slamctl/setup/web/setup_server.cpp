// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/web/setup_server.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "bus/problem_message.hpp"
#include "runtime/clock.hpp"
#include "tools/web/drive/drive_answer.hpp"
#include "tools/web/page_files.hpp"
#include "tools/web/web_pages.hpp"

namespace slam {
namespace {

using httplib::Request;
using httplib::Response;
constexpr std::size_t kLongestBody = 4096;  // [bytes] of an answer or a speed

/// Nothing that would be another line of a configuration.
bool isAnswer(const std::string& text) {
  return text.size() <= WebConsole::kLongestAnswer &&
         std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

}  // namespace

SetupServer::SetupServer(const WebConfig& web, WebConsole& console, const HttpConnection::Limits& limits,
                         TlsContext tls)
    : HttpServer(limits, std::move(tls)), web_(web), console_(console), hosts_(web.address), gate_(web_) {
  set_payload_max_length(kLongestBody);
  set_default_headers(WebPages::headers());
  set_pre_routing_handler([this](const Request& request, Response& response) { return route(request, response); });
  Post(kAnswer, [this](const Request& request, Response& response) { answerQuestion(request, response); });
  Post(kDrive, [this](const Request& request, Response& response) {
    answerDrive(request, response, [this](const DriveRequest& drive) { return console_.drive(drive); });
  });
  set_exception_handler([](const Request&, Response& response, std::exception_ptr) {
    refuse(response, 500, "the set-up could not answer this");
  });
  listenOn(web_.address, web_.port, "give another --web-port, or stop the program that listens there");
  thread_ = std::thread([this] { run(); });
}

SetupServer::~SetupServer() {
  stop();
  thread_.join();
}

httplib::Server::HandlerResponse SetupServer::route(const Request& request, Response& response) const {
  using Handling = httplib::Server::HandlerResponse;
  if (!hosts_.mayEnter(request, response) || redirectsToTls(request, response)) return Handling::Handled;
  const bool reads = request.method == "GET" || request.method == "HEAD";
  const std::string path = request.path == "/" ? "/setup" : request.path;
  if (const PageFile* page = findPageFile(path); page != nullptr && reads) {
    response.status = 200;
    response.set_content(page->content.data(), page->content.size(), page->type);
    return Handling::Handled;
  }
  // A cookie, which a browser sends by itself, is not enough for anything here.
  if (!gate_.mayCommand(request, response, monotonicNow())) return Handling::Handled;
  const bool posts = request.method == "POST" && (path == kAnswer || path == kDrive);
  if (posts && isJson(request, response)) return Handling::Unhandled;
  if (posts) return Handling::Handled;
  if (path == kState && reads) {
    response.status = 200;
    response.set_content(console_.state(), "application/json");
  } else if (const std::string png = reads ? pictureAt(path) : ""; !png.empty()) {
    response.status = 200;
    response.set_content(png, "image/png");
  } else {
    refuse(response, 404, "there is no such page; / has the set-up");
  }
  return Handling::Handled;
}

std::string SetupServer::pictureAt(const std::string& path) const {
  for (const std::string name : {"scans", "map"}) {
    if (path == kState + ("/" + name) + ".png") return console_.picture(name);
  }
  return "";
}

void SetupServer::answerQuestion(const Request& request, Response& response) {
  const auto body = nlohmann::json::parse(request.body, nullptr, false);
  const auto number = body.is_object() ? body.find("number") : body.end();
  const auto answer = body.is_object() ? body.find("answer") : body.end();
  if (number == body.end() || answer == body.end() || !number->is_number_unsigned() || !answer->is_string() ||
      !isAnswer(answer->get<std::string>()))
    return refuse(response, 400, "\"number\" of the question and \"answer\", a line of text, are needed");
  const Problem refusal = console_.take(number->get<std::uint64_t>(), answer->get<std::string>());
  if (!refusal) return answerWith(response, true, "taken", {});
  answerWith(response, false, refusal.words(), {toMessage("setup", refusal, false)});
}

}  // namespace slam
