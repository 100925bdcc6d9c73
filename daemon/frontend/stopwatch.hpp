// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/timestamp.hpp"

namespace slam {

/// Reads a clock for statistics only; given from outside, because pure code cannot read one. nullptr: nothing is timed.
using Stopwatch = Timestamp (*)();

}  // namespace slam
