// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <span>
#include <string_view>

namespace slam {

/// The row of a table of drivers that has this word in the configuration; nullptr: none has.
template <typename Row>
const Row* rowOfDriver(std::span<const Row> table, std::string_view driver) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Row& row) { return row.driver == driver; });
  return found == table.end() ? nullptr : &*found;
}

/// The first row of a table of drivers whose device sends as this one does; nullptr: none does.
template <typename Row, typename LineDevice>
const Row* rowOfLineDevice(std::span<const Row> table, LineDevice line_device) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Row& row) { return row.line_device == line_device; });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace slam
