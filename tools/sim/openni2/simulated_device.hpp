// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <functional>
#include <string>

#include "tools/sim/openni2/simulated_stream.hpp"

namespace slam::sim {

/// The simulated camera as OpenNI2 sees it once it is open: a depth sensor with the modes that slam-sim serves.
class SimulatedDevice : public oni::driver::DeviceBase {
 public:
  SimulatedDevice(std::string path, std::function<void()> lost);

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override;
  oni::driver::StreamBase* createStream(OniSensorType sensor) override;
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }

  OniBool isPropertySupported(int property) override { return property == ONI_DEVICE_PROPERTY_DRIVER_VERSION; }
  OniStatus getProperty(int property, void* data, int* size) override;

 private:
  const std::string path_;
  const std::function<void()> lost_;
  std::array<OniVideoMode, 2 * std::size(kDepthModes)> modes_;  // each in both formats
  OniSensorInfo sensor_;
};

}  // namespace slam::sim
