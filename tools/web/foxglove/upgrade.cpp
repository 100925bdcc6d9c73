// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/upgrade.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <openssl/evp.h>
#include <vector>

#include "tools/web/access/token_gate.hpp"
#include "tools/web/request_guard.hpp"

namespace slam {
namespace {

constexpr int kSwitching = 101;
constexpr std::size_t kKeyLength = 24;                                      // base64 of 16 bytes
constexpr std::array<std::string_view, 2> kProtocols = {"foxglove.sdk.v1",  // the same messages by two names
                                                        "foxglove.websocket.v1"};
constexpr const char* kFoxgloveHost = "app.foxglove.dev";

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The words of a header that is a list.
std::vector<std::string> listOf(const httplib::Request& request, const char* header) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < request.get_header_value_count(header); ++i) {
    std::string word;
    for (const char c : request.get_header_value(header, i) + ",") {
      if (c == ',' && !word.empty()) words.push_back(std::exchange(word, ""));
      if (c != ',' && c != ' ' && c != '\t') word += c;
    }
  }
  return words;
}

bool isMeant(const std::vector<std::string>& words, const char* word) {
  return std::any_of(words.begin(), words.end(), [word](const std::string& one) { return lower(one) == word; });
}

/// Pages of the web have an origin of http or https; one that hides it is "null".
bool mayOpen(const std::string& origin, const std::function<bool(const std::string&)>& isOwnHost) {
  if (origin.empty()) return true;
  const auto scheme_end = origin.find("://");
  if (scheme_end == std::string::npos) return false;
  const std::string scheme = lower(origin.substr(0, scheme_end));
  if (scheme != "http" && scheme != "https") return true;  // of a program on the desktop
  const auto host = hostOf(origin.substr(scheme_end + 3));
  return host && (*host == kFoxgloveHost || isOwnHost(*host));
}

}  // namespace

bool isUpgrade(const httplib::Request& request) { return isMeant(listOf(request, "Upgrade"), "websocket"); }

std::string acceptOf(std::string_view key) {
  const std::string text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // RFC 6455, section 1.3
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha1(), nullptr);
  std::array<unsigned char, 2 * EVP_MAX_MD_SIZE> encoded{};
  const int length = EVP_EncodeBlock(encoded.data(), digest.data(), static_cast<int>(size));
  return {reinterpret_cast<const char*>(encoded.data()), static_cast<std::size_t>(length)};
}

bool upgrade(const httplib::Request& request, httplib::Response& response,
             const std::function<bool(const std::string& host)>& isOwnHost) {
  const std::string key = request.get_header_value("Sec-WebSocket-Key");
  const bool asks = request.method == "GET" && isMeant(listOf(request, "Upgrade"), "websocket") &&
                    isMeant(listOf(request, "Connection"), "upgrade") && key.size() == kKeyLength &&
                    request.get_header_value_count("Sec-WebSocket-Key") == 1;
  if (!asks || request.get_header_value("Sec-WebSocket-Version") != "13") {
    response.set_header("Sec-WebSocket-Version", "13");
    refuse(response, 426, "the only other protocol here is WebSocket 13");
    return false;
  }
  if (request.get_header_value_count("Origin") > 1 || !mayOpen(request.get_header_value("Origin"), isOwnHost)) {
    refuse(response, 403, "a page of another host may not open this");
    return false;
  }
  const std::vector<std::string> offered = listOf(request, "Sec-WebSocket-Protocol");
  const auto known = std::find_if(offered.begin(), offered.end(), [](const std::string& protocol) {
    return std::find(kProtocols.begin(), kProtocols.end(), protocol) != kProtocols.end();
  });
  if (known == offered.end()) {
    refuse(response, 400, "known sub-protocols are foxglove.sdk.v1 and foxglove.websocket.v1");
    return false;
  }
  response.status = kSwitching;
  response.set_header("Upgrade", "websocket");
  response.set_header("Sec-WebSocket-Accept", acceptOf(key));
  response.set_header("Sec-WebSocket-Protocol", *known);
  return true;
}

void finishUpgrade(httplib::Response& response) {
  if (response.status != kSwitching) return;
  for (const char* header : {"Connection", "Keep-Alive", "Content-Length", "Content-Type"})
    response.headers.erase(header);
  response.set_header("Connection", "Upgrade");
}

}  // namespace slam
