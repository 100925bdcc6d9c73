// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/timestamp.hpp"
#include "problems/devices.hpp"

namespace slam {

/// What a read from a port brought.
struct ReadResult {
  enum Status : std::uint8_t { kData, kTimeout, kClosed } status = kTimeout;  ///< kClosed: hung up, do not use it again
  std::size_t size = 0;                                                       ///< [bytes]
};

/// A serial line, real or a pseudo-terminal, or a connection. One thread at a time. Reading waits on the descriptor and
/// never spins.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// Waits up to `timeout` for at least one byte, then takes what is there.
  virtual ReadResult read(std::span<std::uint8_t> out, Duration timeout) = 0;
  /// @return false when not all bytes could be handed to the line
  virtual bool write(std::span<const std::uint8_t> bytes) = 0;
  /// Lets that time pass, whatever comes meanwhile.
  virtual void rest(Duration time);
  virtual void discardInput() = 0;
  /// Modem line DTR; false where the line has none (pseudo-terminal).
  virtual bool setDtr(bool on) = 0;
};

/// Result of opening: a stream, or why not.
struct OpenedPort {
  std::unique_ptr<ByteStream> stream;
  Problem problem = {};  ///< none when opened
};

/// Opens a SerialPort, or a connection where the path is a TcpAddress, which has no baud rate. The path may be a link
/// or a device node of any name: the port is known by its descriptor alone.
OpenedPort openPort(const std::string& path, int baud);

/// How a driver opens its port: openPort(), or a line in virtual time.
using PortOpener = std::function<OpenedPort(const std::string& path, int baud)>;

/// A stream over a descriptor that is open already; takes ownership and makes it non-blocking. @return nullptr where it
/// cannot be waited for: it is a file, or the process has no descriptor left
std::unique_ptr<ByteStream> makeDescriptorStream(int descriptor);

}  // namespace slam
