// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "config/config.hpp"
#include "drivers/can/can_port.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {

/// Are the drives' own watchdogs on, which alone stop the wheels when slamd, the computer or the cable fails?
///
/// A drive tells it in three ways: by its error, when the watchdog has tripped; by going on armed although it gets no
/// frame, as long as no slamd sends any; and, from firmware 0.6 on, when it is asked for the setting, whose number the
/// configuration has to tell. Firmware 0.5 cannot be asked.
/// @param port of the interface @param patience to listen before the drives are asked, longer than their watchdogs'
/// times
Finding checkDriveWatchdogs(const CanConfig& can, CanPort& port, Duration patience = std::chrono::milliseconds(1500));

}  // namespace slam
