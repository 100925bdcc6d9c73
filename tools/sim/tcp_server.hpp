// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "drivers/byte_stream.hpp"

namespace slam::sim {

/// A device's side of TCP on this computer. It takes one program at a time, as most lidars do: the next one is let in
/// and shut out at once.
class TcpServer {
 public:
  /// @param port 0: any that is free. @throws std::system_error where the port is taken
  explicit TcpServer(std::uint16_t port);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  std::uint16_t port() const { return port_; }
  bool isConnected() const { return stream_ != nullptr; }
  /// Waits up to `timeout` for a program or its bytes. @return [bytes] that came
  std::size_t read(std::span<std::uint8_t> out, Duration timeout);
  void send(std::span<const std::uint8_t> bytes);

 private:
  void letIn();

  int listener_;
  std::uint16_t port_ = 0;
  std::unique_ptr<ByteStream> stream_;
};

}  // namespace slam::sim
