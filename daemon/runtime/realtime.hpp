// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace slam {

/// Locks the process's memory, present and future, so that no page fault stops a real-time thread.
/// @return empty, or why not and how to mend it
std::string lockMemory();

/// Gives the calling thread SCHED_FIFO. @return empty, or why not and how to mend it
std::string setFifoPriority(int priority);

/// Names the calling thread for ps and top (15 characters).
void nameThread(const std::string& name);

}  // namespace slam
