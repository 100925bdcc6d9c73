// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace slam {

/// One line on stderr; with the priority prefix that journald reads when it listens. Never from real-time threads.
void logInfo(const std::string& text);
void logWarning(const std::string& text);
void logError(const std::string& text);

}  // namespace slam
