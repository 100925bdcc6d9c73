// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>

namespace slam::test {

/// Whether a pseudo-terminal has modem lines: no kernel gives it any. Of who links modem_lines.cpp.
extern std::atomic<bool> has_modem_lines;
extern std::atomic<int> modem_lines;  ///< those that are on, bits TIOCM_*

}  // namespace slam::test
