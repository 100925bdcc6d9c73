// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/timestamp.hpp"

namespace slam {

/// A kind of fault that a script injects into a device: its name, where its value goes, and which values there are. A
/// switch is 0 or 1, a count whole, a time in ms; what is more than a field has a function, false refuses the value.
template <typename Device>
struct FaultKind {
  std::string_view name;
  std::variant<bool Device::*, int Device::*, double Device::*, Duration Device::*, bool (*)(Device&, double)> what;
  double least = 0.0, most = 1.0;
};

/// @return false for a kind or a value that there is not; nothing is changed then
template <typename Device>
bool injectFault(std::span<const std::type_identity_t<FaultKind<Device>>> kinds, Device& device, std::string_view name,
                 double value) {
  const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& one) { return one.name == name; });
  if (kind == kinds.end() || !(value >= kind->least && value <= kind->most)) return false;
  const auto set = [&](auto what) {
    if constexpr (std::is_pointer_v<decltype(what)>) {
      return what(device, value);
    } else {
      auto& field = device.*what;
      using Field = std::remove_reference_t<decltype(field)>;
      if constexpr (std::is_same_v<Field, Duration>) {
        field = fromSeconds(1e-3 * value);
      } else {
        if (!std::is_same_v<Field, double> && value != std::floor(value)) return false;
        field = static_cast<Field>(value);
      }
      return true;
    }
  };
  return std::visit(set, kind->what);
}

}  // namespace slam
