// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/token_gate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>

#include "bus/problem_message.hpp"
#include "problems/answers.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/web/request_guard.hpp"

namespace slam {
namespace {

constexpr const char* kCookie = "slamd-read";

}  // namespace

std::string drawnSecret() {
  std::random_device source;  // the kernel's
  std::string secret;
  for (int i = 0; i < 4; ++i) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(source()));
    secret += digits;
  }
  return secret;
}

TokenGate::TokenGate(const WebConfig& web) : web_(web), cookie_(drawnSecret()) {}

bool TokenGate::mayRead(const httplib::Request& request, httplib::Response& response, Timestamp now) const {
  return web_.read == WebReaders::kAnybody || hasCookie(request) || hasToken(request, response, now);
}

bool TokenGate::mayCommand(const httplib::Request& request, httplib::Response& response, Timestamp now) const {
  if (web_.commands) return hasToken(request, response, now);
  refuse(response, 403, answerOf({answer::kWebOff}));
  return false;
}

bool TokenGate::unlock(const httplib::Request& request, httplib::Response& response, Timestamp now) const {
  if (!web_.needsToken()) return mayCommand(request, response, now);
  if (!hasToken(request, response, now)) return false;
  response.set_header("Set-Cookie",
                      kCookie + ("=" + cookie_) + "; Path=/; HttpOnly; SameSite=Strict" + (web_.tls ? "; Secure" : ""));
  return true;
}

bool TokenGate::hasCookie(const httplib::Request& request) const {
  const std::string name = kCookie + std::string("=");
  const std::string cookies = request.get_header_value("Cookie");
  for (std::size_t begin = 0; begin < cookies.size();) {
    const std::size_t end = std::min(cookies.find(';', begin), cookies.size());
    const std::string_view cookie(cookies.data() + begin, end - begin);
    if (cookie.starts_with(name) && isSameSecret(cookie.substr(name.size()), cookie_)) return true;
    begin = std::min(cookies.find_first_not_of("; ", end), cookies.size());
  }
  return false;
}

bool TokenGate::hasToken(const httplib::Request& request, httplib::Response& response, Timestamp now) const {
  const bool given = request.get_header_value_count("Authorization") == 1;
  const std::lock_guard lock(guessing_);
  if (const Duration wait = throttle_.wait(request.remote_addr, now); given && wait > Duration(0)) {
    const double seconds = std::ceil(toSeconds(wait));
    response.set_header("Retry-After", std::to_string(static_cast<int>(seconds)));
    refuse(response, 429, answerOf({{answer::kManyTokens, {seconds}}}));
    return false;
  }
  if (given && isSameSecret(bearerOf(request.get_header_value("Authorization")), web_.token)) {
    throttle_.right(request.remote_addr);
    return true;
  }
  if (given) throttle_.wrong(request.remote_addr, now);
  response.set_header("WWW-Authenticate", "Bearer");
  refuse(response, 401, answerOf({given ? answer::kWrongToken : answer::kNeedsToken}));
  return false;
}

void refuse(httplib::Response& response, int status, const std::string& words) {
  response.status = status;
  response.set_content(words + "\n", "text/plain; charset=utf-8");
}

void refuse(httplib::Response& response, int status, const Answer& why) {
  refuse(response, status, why.words);
  auto parts = nlohmann::json::array();
  for (const Problem& part : why.parts) parts.push_back(problemJson(toMessage("page", part, false)));
  response.set_header(kPartsHeader,
                      parts.dump(-1, ' ', /*ensure_ascii=*/true, nlohmann::json::error_handler_t::replace));
}

}  // namespace slam
