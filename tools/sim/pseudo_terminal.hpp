// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <memory>

#include "drivers/byte_stream.hpp"

namespace slam::sim {

/// A pseudo-terminal in raw mode with a link to the side that a driver opens. The emulator's side stays usable while no
/// driver is there.
class PseudoTerminal {
 public:
  /// @throws std::system_error when the system gives no pseudo-terminal or the link cannot be made
  explicit PseudoTerminal(const std::filesystem::path& link);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  ByteStream& stream();
  /// Of the side that a driver opens.
  int descriptor() const { return slave_; }
  /// Writes what fits: like a line without flow control, a reader that is away loses bytes.
  void send(std::span<const std::uint8_t> bytes);

 private:
  std::filesystem::path link_;
  std::unique_ptr<ByteStream> stream_;
  int slave_;  // held open, so that the emulator's side is never hung up
};

}  // namespace slam::sim
