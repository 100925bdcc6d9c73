// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "slam/refine/map_refinement.hpp"

namespace slam {

/// The figures of a map before and after as a table, and why it was kept, or where it is stored.
/// @param stored name that the result has; empty: that of the map
std::string wordsOf(const RefineReport& report, const std::string& name, const std::string& stored = {});

}  // namespace slam
