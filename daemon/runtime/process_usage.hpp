// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace slam {

double cpuSeconds();             ///< [s] of CPU this process has used
double residentMegabytes();      ///< [MB] now
double peakResidentMegabytes();  ///< [MB] most so far
/// @return [MB] free for files at `path` (or the folder it would lie in), -1 when that is not known
double diskFreeMegabytes(const std::string& path);

}  // namespace slam
