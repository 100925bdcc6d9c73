// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

/// What all records of a sensor show together, and none of them alone.

namespace slam {

/// The middle one; there is one at least.
template <typename T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Counts a lidar's ranges to find the values that it writes where nothing came back. Such a code lies at the rim of
/// what the lidar measures, and beams of many directions share it, exactly; of what is real, they share none.
class RangeCensus {
 public:
  static constexpr double kStep = 0.001;  ///< [m] ranges that differ by less count as one

  /// @param beam index of the beam, of a scan of so many beams
  void add(std::size_t beam, std::size_t beams, double range);

  /// [m] ascending
  std::vector<double> codes() const;
  bool empty() const { return total_ == 0; }
  /// [m] of all, codes too
  double largest() const;
  /// [m] beyond which nothing is a return: above all ranges, below all codes
  double limit() const;

 private:
  struct Bin {
    std::uint32_t count = 0;
    std::uint64_t directions = 0;  // a bit for each 64th of the scan
  };
  std::vector<Bin> bins_;
  std::uint64_t total_ = 0;
};

/// The range is this code.
bool isCode(double range, double code);

/// Finds out whether the times of a turning lidar's beams are those of its driver, which copied a turn that was
/// complete: they span next to nothing of the time from scan to scan. Such a turn was measured before its stamps.
class BeamTimes {
 public:
  /// @param first, last [us] of the scan's beams
  void add(std::int64_t first, std::int64_t last);

  /// [us] that a turn takes where the beams' times are those of a copy; nullopt: they are not
  std::optional<std::int64_t> copiedTurn() const;

 private:
  std::vector<std::int64_t> spans_, periods_;  // [us]
  std::optional<std::int64_t> last_;
};

/// The least delay of a sensor's messages from stamp to receipt. Taken as none, it puts the sensor's clock on the
/// recorder's.
struct ReceiptDelay {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();  ///< [us] which no delay is

  void add(std::int64_t delay) { least = std::min(least, delay); }
  bool known() const { return least != std::numeric_limits<std::int64_t>::max(); }
};

}  // namespace slam
