// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slam {

/// Nodes of a graph. To be kept and cleared: that costs nothing, nor does it allocate while the graph stays as large.
class NodeSet {
 public:
  void clear() { ++now_; }
  /// @return whether it was not in it
  bool insert(int node) {
    const auto i = static_cast<std::size_t>(node);
    if (i >= since_.size()) since_.resize(i + i / 2 + 1, 0);
    const bool is_new = since_[i] != now_;
    since_[i] = now_;
    return is_new;
  }
  bool contains(int node) const {
    const auto i = static_cast<std::size_t>(node);
    return i < since_.size() && since_[i] == now_;
  }

 private:
  std::uint64_t now_ = 1;
  std::vector<std::uint64_t> since_;  // by node: the last clear() before it was inserted
};

}  // namespace slam
