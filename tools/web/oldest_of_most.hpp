// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstddef>
#include <map>
#include <string_view>

namespace slam {

/// Who has to make place for others, so that no address can keep all of them out: the oldest one of the address that
/// has most. @param all the oldest first; not empty @param addressOf one of them, as a std::string_view @return its
/// index
template <typename All, typename AddressOf>
std::size_t oldestOfMost(const All& all, AddressOf&& addressOf) {
  std::map<std::string_view, std::size_t> counts;
  for (const auto& one : all) ++counts[addressOf(one)];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto oldest =
      std::find_if(all.begin(), all.end(), [&](const auto& one) { return addressOf(one) == most->first; });
  return static_cast<std::size_t>(oldest - all.begin());
}

}  // namespace slam
