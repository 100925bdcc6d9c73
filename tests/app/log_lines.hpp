// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <iterator>
#include <vector>

#include "app/log/log.hpp"
#include "core/timestamp.hpp"

namespace slam::test {

struct LoggedLine {
  Duration at;
  LogLine line;
};

/// @param lines in order
inline int mostWithinAnHour(const std::vector<LoggedLine>& lines) {
  std::ptrdiff_t most = 0;
  for (auto first = lines.begin(), end = first; first != lines.end(); ++first) {
    while (end != lines.end() && end->at < first->at + std::chrono::hours(1)) ++end;
    most = std::max(most, end - first);
  }
  return static_cast<int>(most);
}

}  // namespace slam::test
