// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace slam {

/// The line under points (index, time) of something steady that is seen late by varying delays: the least late points
/// are its witnesses, and two of them far apart tell the period. Old witnesses go, so that a step is forgotten.
/// [Olson 2010] E. Olson, "A passive solution to the sensor synchronization problem", Proc. IROS 2010.
class LowerEnvelope {
 public:
  /// @param period [ns] to begin with
  explicit LowerEnvelope(double period) : period_(period) {}

  /// @param index grows from call to call @param time [ns]
  void add(std::int64_t index, std::int64_t time) {
    if (!present_ || time < predict(*present_, index)) present_ = Witness{index, time};
    if (++in_bucket_ < bucket_) return;
    learn();
    previous_ = present_;
    present_.reset();
    in_bucket_ = 0;
    bucket_ = std::min(2 * bucket_, kLargestBucket);  // the better the period is known, the longer a witness is good
  }
  /// The index may have lost count: the line begins anew with the next point, the period stays.
  void forget() {
    if (in_bucket_ >= kFirstBucket) learn();
    previous_.reset();
    present_.reset();
    in_bucket_ = 0;
  }
  /// [ns], of the line; there must have been a point
  std::int64_t at(std::int64_t index) const {
    if (!previous_) return predict(*present_, index);
    if (!present_) return predict(*previous_, index);
    return std::min(predict(*previous_, index), predict(*present_, index));
  }
  double period() const { return period_; }  ///< [ns]

 private:
  struct Witness {
    std::int64_t index, time;
  };
  static constexpr std::size_t kHistory = 16;
  static constexpr int kFirstBucket = 32, kLargestBucket = 128;  // points of which one witness is kept

  void learn() {
    history_[kept_++ % kHistory] = *present_;
    if (kept_ < 3) return;
    const Witness& oldest = history_[kept_ > kHistory ? kept_ % kHistory : 0];
    period_ = static_cast<double>(present_->time - oldest.time) / static_cast<double>(present_->index - oldest.index);
  }
  std::int64_t predict(const Witness& witness, std::int64_t index) const {
    return witness.time + static_cast<std::int64_t>(static_cast<double>(index - witness.index) * period_);
  }

  double period_;
  int bucket_ = kFirstBucket, in_bucket_ = 0;
  std::optional<Witness> previous_, present_;
  std::array<Witness, kHistory> history_{};
  std::size_t kept_ = 0;
};

}  // namespace slam
