// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

namespace slam::test {

/// What this process asked the disk to hold, by name, in this order. fsync and fdatasync of this executable note it
/// and then ask the kernel.
std::vector<std::string>& syncLog();

}  // namespace slam::test
