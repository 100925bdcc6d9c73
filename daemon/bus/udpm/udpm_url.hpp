// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <netinet/in.h>
#include <string>

namespace slam {

/// An LCM URL of the provider udpm: udpm://ADDRESS:PORT?ttl=N&recv_buf_size=BYTES, of which all but the provider may be
/// left out.
struct UdpmUrl {
  std::string text;          ///< the whole, for liblcm
  sockaddr_in group{};       ///< where messages are sent to
  int ttl = 0;               ///< 0: messages stay on this machine
  int receive_buffer = 0;    ///< [bytes] of the kernel's; 0: the default
  std::string name() const;  ///< ADDRESS:PORT
  int port() const { return ntohs(group.sin_port); }
};

/// What liblcm would only grumble at (a port without number, an unknown argument) is refused.
/// @throws std::invalid_argument with the URL and what is wrong with it
UdpmUrl parseUdpmUrl(const std::string& url);

}  // namespace slam
