// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/udpm_url.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstdlib>
#include <limits>
#include <stdexcept>

namespace slam {
namespace {

constexpr char kProvider[] = "udpm://";
constexpr char kDefaultGroup[] = "239.255.76.67:7667";  // liblcm's own

/// Decimal, 0x... or 0..., as liblcm reads them, but the whole text.
int numberIn(const std::string& text, int min, int max, const std::string& what) {
  char* end = nullptr;
  errno = 0;
  const long value = std::strtol(text.c_str(), &end, 0);
  if (end == text.c_str() || *end != '\0' || errno != 0 || value < min || value > max) {
    throw std::invalid_argument("has \"" + text + "\" for " + what + ", which is a number from " + std::to_string(min) +
                                " to " + std::to_string(max));
  }
  return static_cast<int>(value);
}

void setArgument(UdpmUrl& url, const std::string& argument) {
  const auto equals = argument.find('=');
  const std::string key = argument.substr(0, equals);
  const std::string value = equals == std::string::npos ? "" : argument.substr(equals + 1);
  if (key == "ttl") {
    url.ttl = numberIn(value, 0, 255, key);
  } else if (key == "recv_buf_size") {
    url.receive_buffer = numberIn(value, 0, std::numeric_limits<int>::max(), key);
  } else {
    throw std::invalid_argument("has the unknown argument \"" + key + "\"; known are ttl and recv_buf_size");
  }
}

UdpmUrl parsed(const std::string& text) {
  if (!text.starts_with(kProvider))
    throw std::invalid_argument("does not name LCM's provider udpm, the only one that slamd works with");
  UdpmUrl url{.text = text};
  const std::string rest = text.substr(sizeof kProvider - 1);
  const auto question = rest.find('?');
  std::string group = rest.substr(0, question);
  if (group.empty()) group = kDefaultGroup;
  const auto colon = group.find(':');
  url.group.sin_family = AF_INET;
  const std::string address = group.substr(0, colon);
  if (inet_pton(AF_INET, address.c_str(), &url.group.sin_addr) != 1 || !IN_MULTICAST(ntohl(url.group.sin_addr.s_addr)))
    throw std::invalid_argument("has \"" + address + "\" for a multicast address (224.0.0.0 to 239.255.255.255)");
  const std::string port = colon == std::string::npos ? "" : group.substr(colon + 1);
  url.group.sin_port = htons(static_cast<std::uint16_t>(numberIn(port, 1, 65535, "the port")));
  if (question == std::string::npos) return url;
  for (std::size_t at = question; at != std::string::npos;) {
    const auto next = rest.find_first_of("&,", at + 1);
    const std::string argument = rest.substr(at + 1, next == std::string::npos ? next : next - at - 1);
    if (!argument.empty()) setArgument(url, argument);
    at = next;
  }
  return url;
}

}  // namespace

std::string UdpmUrl::name() const {
  char address[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &group.sin_addr, address, sizeof address);
  return std::string(address) + ":" + std::to_string(port());
}

UdpmUrl parseUdpmUrl(const std::string& url) {
  try {
    return parsed(url);
  } catch (const std::invalid_argument& problem) {
    throw std::invalid_argument("\"" + url + "\" " + problem.what() + "; use udpm://ADDRESS:PORT?ttl=0");
  }
}

}  // namespace slam
