// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdio>
#include <string>

namespace slam {

/// @param format of printf, with one number in it
inline std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace slam
