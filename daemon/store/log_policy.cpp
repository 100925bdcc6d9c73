// SPDX-License-Identifier: BSD-3-Clause
#include "store/log_policy.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <numeric>

namespace slam {

std::string utcName(std::int64_t utime) {
  const auto seconds = static_cast<std::time_t>(utime / 1000000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H-%M-%SZ", &utc);
  return text.data();
}

std::string runName(std::int64_t utime, const std::string& boot_id) {
  return utcName(utime) + "_" + (boot_id.empty() ? "unknown" : boot_id);
}

std::int64_t nextNumber(std::span<const LogFile> files) {
  std::int64_t next = 0;
  for (const LogFile& file : files) next = std::max(next, file.number + 1);
  return next;
}

bool isFull(Duration age, std::uint64_t bytes, const LogLimits& limits) {
  return age >= limits.file_length || bytes >= limits.fileBytes();
}

bool hasRoom(std::uint64_t free, std::uint64_t floor, bool writing) {
  return free >= (writing ? floor : floor + floor / 10);
}

std::vector<std::size_t> filesToRemove(std::span<const LogFile> closed, std::uint64_t free, const LogLimits& limits) {
  std::vector<std::size_t> order(closed.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto marked =
      std::stable_partition(order.begin(), order.end(), [&](std::size_t i) { return !closed[i].marked; });
  const auto bytes = [&](auto first, auto last) {
    return std::accumulate(first, last, std::uint64_t{0},
                           [&](std::uint64_t sum, std::size_t i) { return sum + closed[i].bytes; });
  };

  auto kept = order.begin();
  std::uint64_t rest = bytes(order.begin(), order.end());
  const auto drop = [&] {
    rest -= closed[*kept].bytes;
    free += closed[*kept].bytes;
    ++kept;
  };
  while (kept != order.end() && rest > limits.quota - 2 * limits.fileBytes()) drop();
  // A little above the floor, so that writing need not stop first.
  if (free < limits.floor + limits.floor / 20) {
    const std::uint64_t wanted = limits.floor + limits.floor / 10;
    if (kept < marked && free + bytes(kept, marked) >= wanted) {
      while (kept < marked && free < wanted) drop();
    }
  }
  return {order.begin(), kept};
}

}  // namespace slam
