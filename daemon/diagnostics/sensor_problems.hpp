// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "diagnostics/sensor_check.hpp"
#include "frontend/interpreter/echo_watch.hpp"
#include "problems/sensors.hpp"

namespace slam {

Problem problemOf(const SensorFinding& finding);
Problem problemOf(EchoWatch::Finding finding);

}  // namespace slam
