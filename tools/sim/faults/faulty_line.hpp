// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

#include "tools/sim/faults/line_faults.hpp"
#include "tools/sim/pseudo_terminal.hpp"
#include "tools/sim/tcp_server.hpp"

namespace slam::sim {

/// The serial line between an emulator and whoever opens the link, or the connection of whoever comes to the TCP port,
/// with the line's faults. For one thread, but for LineFaults::inject, which is to be called from it too.
class FaultyLine {
 public:
  /// @throws std::system_error when there is no pseudo-terminal or the link cannot be made
  explicit FaultyLine(const std::filesystem::path& link) : link_(link) { plugIn(); }
  /// @param port 0: any that is free
  explicit FaultyLine(std::uint16_t port) : tcp_port_(port) { plugIn(); }

  /// Faults of LineFaults; and "baud", the only rate [bit/s] at which the device is understood and understands, 0: any.
  /// @return false for another one
  bool inject(std::string_view kind, double value);

  /// Bytes from the host; waits for them up to `timeout`. None while unplugged.
  std::vector<std::uint8_t> receive(Duration timeout);
  void send(std::vector<std::uint8_t> bytes, Timestamp now);

 private:
  void plugIn();
  bool isUnderstood() const;

  std::filesystem::path link_;
  std::optional<std::uint16_t> tcp_port_;
  std::optional<PseudoTerminal> port_;
  std::optional<TcpServer> server_;
  LineFaults faults_;
  int baud_ = 0;  // [bit/s] of the device; 0: a pseudo-terminal carries any
  std::mt19937 random_{1};
};

}  // namespace slam::sim
