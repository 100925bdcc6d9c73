// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/imu/imu_protocol.hpp"

/// The makes of the table, each in a file of its own.
namespace slam {

/// CEVA (Hillcrest, Bosch) BNO080, BNO085, BNO086 in UART-RVC mode: it only sends. It measures no turn rate; that comes
/// from the difference of its attitudes.
std::unique_ptr<ImuProtocol> makeBno08xProtocol();
/// HandsFree A9, B6, B9, D6: which of the two framings it uses is found out from what comes.
std::unique_ptr<ImuProtocol> makeHfiProtocol();
/// WitMotion WT901, HWT905, JY901 and their kin: it only sends.
std::unique_ptr<ImuProtocol> makeWitmotionProtocol();
/// Xsens MTi: frames of MTData2. One that has been left in its configuration state is sent back to measure; nothing of
/// its settings is changed.
std::unique_ptr<ImuProtocol> makeXsensProtocol();

}  // namespace slam
