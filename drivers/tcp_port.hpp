// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/byte_stream.hpp"

namespace slam {

/// Where a device on the network is: tcp://ADDRESS:PORT, as in "tcp://192.168.0.10:10940" or "tcp://[fe80::1]:2112". No
/// names: looking one up may take for ever.
struct TcpAddress {
  std::string host;
  std::uint16_t port = 0;
};
/// Whether a path is of that kind, rightly written or not.
bool isTcp(std::string_view path);
/// @return std::nullopt where it is no such address
std::optional<TcpAddress> parseTcp(std::string_view path);

/// Connects, within a second. The stream's reads are those of a serial port; a connection that the device ends is a
/// hang-up.
OpenedPort openTcp(const std::string& path);

}  // namespace slam
