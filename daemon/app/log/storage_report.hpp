// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "core/timestamp.hpp"

namespace slam {

/// How writing to a disk goes, for health and log.
struct StorageReport {
  std::string problem;  ///< what is not written and why, what slamd does meanwhile, and the fix; empty: nothing
  std::string lost;     ///< what is missing for good
  Duration waiting{0};  ///< for the disk, so far
};

}  // namespace slam
