// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "tools/web/logs/log_folder.hpp"

namespace slam {

/// The page that lists a folder of field logs, with links that logPathOf() takes. @param parts of the folder's path
std::string logPage(const std::vector<std::string>& parts, const std::vector<LogFolder::Entry>& entries);

}  // namespace slam
