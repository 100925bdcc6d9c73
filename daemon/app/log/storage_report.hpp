// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "core/timestamp.hpp"
#include "problems/daemon.hpp"

namespace slam {

/// Why something is not written, as far as the table of problems does not have it.
struct StorageProblem {
  Problem problem = {};
  std::string since = {};      ///< that its words begin with
  std::string meanwhile = {};  ///< what slamd does; empty: as the table has it

  std::string words() const { return since + problem.words(meanwhile); }
};

/// How writing to a disk goes, for health and log.
struct StorageReport {
  StorageProblem problem = {};
  Problem lost = {};    ///< what is missing for good
  Duration waiting{0};  ///< for the disk, so far
};

}  // namespace slam
