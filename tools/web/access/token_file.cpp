// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/token_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "config/loader.hpp"

namespace slam {

std::string tokenOf(const WebConfig& web) {
  if (!web.needsToken() || !web.token.empty()) return web.token;
  constexpr std::streamsize kLongest = 1024;  // [bytes]
  const std::string fix = "; make one: sudo install -m 640 -g slamd /dev/null " + web.token_file +
                          " && openssl rand -hex 16 | sudo tee " + web.token_file +
                          ", or set web.commands = false and web.read = \"anybody\"";
  errno = 0;
  std::ifstream file(web.token_file);
  char text[kLongest];
  file.read(text, kLongest);
  if (!file.is_open() || file.bad()) {
    throw ConfigError({"web.token_file: cannot read " + web.token_file + ": " + std::strerror(errno) + fix});
  }
  std::string token(text, static_cast<std::size_t>(file.gcount()));
  token.erase(token.find_last_not_of(" \t\r\n") + 1);
  if (token.size() >= WebConfig::kShortestToken && token.find_first_of("\r\n") == std::string::npos) return token;
  throw ConfigError({"web.token_file: " + web.token_file + " holds no line of " +
                     std::to_string(WebConfig::kShortestToken) + " characters or more" + fix});
}

}  // namespace slam
