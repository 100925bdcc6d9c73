// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

namespace slam {

/// The stop that is owed to wheels while nobody commands them. A drive keeps the last speed it was given, by whomever,
/// and what it last received cannot be known: a stop is owed from the start, again from each moment at which frames may
/// have been lost or the drive may have begun anew, and from each command on, for the time when it has become too old.
/// Zeros that the link has accepted settle it.
class StopDebt {
 public:
  /// @param zeros accepted ones that settle it; 0: speeds may not be sent, and none is ever owed
  explicit StopDebt(int zeros) : zeros_(zeros), left_(zeros) {}

  void owe() { left_ = zeros_; }
  void zeroAccepted() { left_ = std::max(0, left_ - 1); }
  bool owed() const { return left_ > 0; }

 private:
  int zeros_, left_;
};

}  // namespace slam
