// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "tools/sim/faults/line_faults.hpp"
#include "tools/sim/pseudo_terminal.hpp"

namespace slam::sim {

/// The serial line between an emulator and whoever opens the link, with the line's faults. For one thread, but for
/// LineFaults::inject, which is to be called from it too.
class FaultyLine {
 public:
  /// @throws std::system_error when there is no pseudo-terminal or the link cannot be made
  explicit FaultyLine(const std::filesystem::path& link) : link_(link) { port_.emplace(link_); }

  /// @return false for a fault that LineFaults does not know
  bool inject(std::string_view kind, double value);

  /// Bytes from the host; waits for them up to `timeout`. None while unplugged.
  std::vector<std::uint8_t> receive(Duration timeout);
  void send(std::vector<std::uint8_t> bytes, Timestamp now);

 private:
  std::filesystem::path link_;
  std::optional<PseudoTerminal> port_;
  LineFaults faults_;
};

}  // namespace slam::sim
