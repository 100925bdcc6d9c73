// SPDX-License-Identifier: BSD-3-Clause
#include "bus/multicast_route.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace slam {

bool hasMulticastRoute(const std::string& url) {
  const auto scheme = url.find("udpm://");
  if (scheme == std::string::npos) return true;
  const std::string address = url.substr(scheme + 7, url.find_first_of(":?", scheme + 7) - scheme - 7);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(7667);
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) return true;
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return true;
  const bool routed = connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  close(fd);
  return routed;
}

}  // namespace slam
