// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>

#include "tools/slamctl/setup/interview.hpp"
#include "tools/slamctl/setup/machine.hpp"

namespace slam {

/// Puts what was found into the configuration, and asks for what no port tells: which of two devices of one kind, the
/// size of the wheels, where lidar and camera sit. A setting that already fits what was found stays.
/// @param again looks at the ports once more, after a person has unplugged a device
/// @throws std::runtime_error where two devices of one kind are there, and nobody can be asked
void proposeDevices(Interview& interview, Machine machine, const std::function<Machine()>& again);

}  // namespace slam
