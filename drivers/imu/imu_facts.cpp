// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/imu_facts.hpp"

#include "drivers/imu/imu_protocols.hpp"
#include "drivers/search/driver_row.hpp"

namespace slam {
namespace {

constexpr std::array kTable = {
    ImuFacts{.driver = "hfi",
             .name = "a HandsFree IMU",
             .line_device = LineDevice::kImu,
             .make = makeHfiProtocol,
             .bauds = {921600}},
    ImuFacts{.driver = "bno08x",
             .name = "a BNO08x in UART-RVC mode",
             .line_device = LineDevice::kBno08x,
             .make = makeBno08xProtocol,
             .bauds = {115200},
             .rate = 100.0,
             .silence = ", and that its pin PS0 is high and PS1 low: UART-RVC mode"},
    ImuFacts{.driver = "witmotion",
             .name = "a WitMotion IMU",
             .line_device = LineDevice::kWitmotion,
             .make = makeWitmotionProtocol,
             .bauds = {115200, 9600, 230400, 921600, 57600, 38400, 19200, 460800},
             .output = "acceleration (0x51) and angular velocity (0x52), at 100 Hz and 115200 bit/s"},
    ImuFacts{.driver = "xsens",
             .name = "an Xsens MTi",
             .line_device = LineDevice::kXsens,
             .make = makeXsensProtocol,
             .bauds = {115200, 921600, 460800, 230400},
             .output = "rate of turn (8020), acceleration (4020) and sample time (1060) as floats, at 100 Hz"},
};

}  // namespace

std::span<const ImuFacts> imuTable() { return kTable; }

const ImuFacts* findImu(std::string_view driver) { return rowOfDriver(imuTable(), driver); }

}  // namespace slam
