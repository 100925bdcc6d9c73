// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slam {

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

}  // namespace slam
