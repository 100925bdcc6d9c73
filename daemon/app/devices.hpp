// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "app/channels.hpp"
#include "app/threads/device_thread.hpp"
#include "config/config.hpp"
#include "drivers/camera/openni_camera.hpp"
#include "drivers/lidar/serial_lidar.hpp"

namespace slam {

/// What reads the lidar of the configuration; nullptr where that is to be found.
std::unique_ptr<LidarUnit> makeLidarUnit(const Config& config);
/// What finds it; empty where it is known.
LidarFinder lidarFinder(const Config& config);
using LidarThread = DeviceThread<SerialLidar>;
/// Thread *lidar*: scans into the queues.
std::unique_ptr<LidarThread> makeLidarThread(const Config& config, const SampleProducer<ReceivedScan>& scans);

using DepthThread = DeviceThread<OpenniCamera>;
/// Thread *depth*: pseudo-lasers into the queues.
/// @param record_to as of OpenniConfig
std::unique_ptr<DepthThread> makeDepthThread(const Config& config, const DepthEnds& ends,
                                             std::function<std::string()> record_to = {});

}  // namespace slam
