// SPDX-License-Identifier: BSD-3-Clause
#include "app/log.hpp"

#include <cstdio>
#include <cstdlib>
#include <systemd/sd-daemon.h>

namespace slam {
namespace {

void logLine(const char* priority, const char* word, const std::string& text) {
  static const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  std::fprintf(stderr, "%sslamd: %s%s\n", journal ? priority : "", word, text.c_str());
}

}  // namespace

void logInfo(const std::string& text) { logLine(SD_INFO, "", text); }
void logWarning(const std::string& text) { logLine(SD_WARNING, "warning: ", text); }
void logError(const std::string& text) { logLine(SD_ERR, "error: ", text); }

}  // namespace slam
