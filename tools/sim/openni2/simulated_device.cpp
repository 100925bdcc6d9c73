// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/openni2/simulated_device.hpp"

#include <cstring>

namespace slam::sim {

SimulatedDevice::SimulatedDevice(std::string path, std::function<void()> lost)
    : path_(std::move(path)), lost_(std::move(lost)) {
  std::size_t i = 0;
  for (const DepthMode& mode : kDepthModes) {
    for (const OniPixelFormat format : {ONI_PIXEL_FORMAT_DEPTH_1_MM, ONI_PIXEL_FORMAT_DEPTH_100_UM}) {
      modes_[i++] = {format, mode.width, mode.height, mode.rate};
    }
  }
  sensor_ = {ONI_SENSOR_DEPTH, static_cast<int>(modes_.size()), modes_.data()};
}

OniStatus SimulatedDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
  *sensors = &sensor_;
  *count = 1;
  return ONI_STATUS_OK;
}

oni::driver::StreamBase* SimulatedDevice::createStream(OniSensorType sensor) {
  return sensor == ONI_SENSOR_DEPTH ? new SimulatedStream(path_, lost_) : nullptr;
}

OniStatus SimulatedDevice::getProperty(int property, void* data, int* size) {
  constexpr OniVersion kVersion{1, 0, 0, 0};
  if (property != ONI_DEVICE_PROPERTY_DRIVER_VERSION) return ONI_STATUS_NOT_SUPPORTED;
  if (*size != static_cast<int>(sizeof kVersion)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &kVersion, sizeof kVersion);
  return ONI_STATUS_OK;
}

}  // namespace slam::sim
