// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <span>
#include <string_view>

#include "frontend/front_end_config.hpp"

namespace slam {

/// A rule of the front end that can be left out alone. docs/algorithms.md explains them; no key of a file does this.
struct Rule {
  std::string_view name;
  std::function<void(FrontEndConfig&)> leave_out;
};
std::span<const Rule> frontEndRules();

}  // namespace slam
