// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/log.hpp"

#include <cstdio>
#include <cstdlib>
#include <systemd/sd-daemon.h>

namespace slam {

void logLine(const LogLine& line) {
  static const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  const char* const priorities[] = {SD_INFO, SD_WARNING, SD_ERR};
  const char* const words[] = {"", "warning: ", "error: "};
  std::fprintf(stderr, "%sslamd: %s%s\n", journal ? priorities[line.level] : "", words[line.level], line.text.c_str());
}

}  // namespace slam
