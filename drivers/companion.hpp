// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slam {

/// Whether a device sends a second reading with each of a first one, learned from what comes. Expected from the
/// beginning; not any more when it is there with fewer than three of five, which loss on a line that is of any use does
/// not do; again when it is there with nearly each.
class Companion {
 public:
  /// One of the first readings. @param there whether the second came with it
  void note(bool there) {
    share_ += kGain * ((there ? 1.0 : 0.0) - share_);
    expected_ = share_ > (expected_ ? kSeldom : kSteady);
  }
  bool expected() const { return expected_; }

 private:
  static constexpr double kGain = 1.0 / 64.0, kSeldom = 0.6, kSteady = 0.9;
  double share_ = 1.0;
  bool expected_ = true;
};

}  // namespace slam
