// SPDX-License-Identifier: BSD-3-Clause
#include "graph/node_index.hpp"

#include <algorithm>
#include <cmath>

namespace slam {

std::int32_t NodeIndex::coordinate(double metres) const {
  const double cells = std::floor(metres / cell_);
  return std::isnan(cells) ? 0 : static_cast<std::int32_t>(std::clamp(cells, -1e9, 1e9));  // also what is no pose
}

NodeIndex::Cell NodeIndex::cell(std::int32_t x, std::int32_t y) {
  return Cell{static_cast<std::uint32_t>(x)} << 32U | static_cast<std::uint32_t>(y);
}

void NodeIndex::add(const Eigen::Vector2d& p_map) {
  cell_of_.push_back(cell(coordinate(p_map.x()), coordinate(p_map.y())));
  nodes_[cell_of_.back()].push_back(static_cast<int>(cell_of_.size()) - 1);
}

void NodeIndex::move(int node, const Eigen::Vector2d& p_map) {
  Cell& now = cell_of_[static_cast<std::size_t>(node)];
  const Cell next = cell(coordinate(p_map.x()), coordinate(p_map.y()));
  if (next == now) return;
  erase(node);
  now = next;
  nodes_[next].push_back(node);
}

void NodeIndex::erase(int node) {
  const auto at = nodes_.find(cell_of_[static_cast<std::size_t>(node)]);
  std::erase(at->second, node);
  if (at->second.empty()) nodes_.erase(at);
}

void NodeIndex::truncate(int count) {
  for (int node = count; node < static_cast<int>(cell_of_.size()); ++node) erase(node);
  cell_of_.resize(static_cast<std::size_t>(count));
}

std::vector<int> NodeIndex::candidates(const Eigen::Vector2d& p_map, double radius) const {
  std::vector<int> found;
  const std::int32_t x0 = coordinate(p_map.x() - radius), x1 = coordinate(p_map.x() + radius),
                     y0 = coordinate(p_map.y() - radius), y1 = coordinate(p_map.y() + radius);
  const auto take = [&](const std::vector<int>& nodes) { found.insert(found.end(), nodes.begin(), nodes.end()); };
  if ((static_cast<double>(x1) - x0 + 1.0) * (static_cast<double>(y1) - y0 + 1.0) >
      static_cast<double>(nodes_.size())) {
    for (const auto& [at, nodes] : nodes_) take(nodes);
    return found;
  }
  for (std::int32_t x = x0; x <= x1; ++x) {
    for (std::int32_t y = y0; y <= y1; ++y) {
      if (const auto at = nodes_.find(cell(x, y)); at != nodes_.end()) take(at->second);
    }
  }
  return found;
}

}  // namespace slam
