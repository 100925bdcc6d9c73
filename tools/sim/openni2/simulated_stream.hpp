// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Driver/OniDriverAPI.h>
#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "tools/sim/openni2/frame_source.hpp"

namespace slam::sim {

/// Depth stream of the simulated camera. Properties, their sizes and the mirrored default are the real device's
/// [OpenNI2 2.2, Source/Drivers/PS1080]; unlike there, the video mode cannot be set while the stream runs.
class SimulatedStream : public oni::driver::StreamBase {
 public:
  /// @param lost called, from the stream's thread, when the camera goes away while it streams
  SimulatedStream(std::string path, std::function<void()> lost) : path_(std::move(path)), lost_(std::move(lost)) {}
  ~SimulatedStream() override { SimulatedStream::stop(); }

  OniStatus start() override;
  void stop() override;

  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;

 private:
  struct Settings {
    OniVideoMode mode{ONI_PIXEL_FORMAT_DEPTH_1_MM, 320, 240, 30};
    OniCropping cropping{FALSE, 0, 0, 320, 240};
    OniBool mirrored = TRUE;
  };

  OniStatus setMode(const OniVideoMode& mode);
  OniStatus setCropping(const OniCropping& cropping);
  void run();
  void deliver(const DepthFrameHeader& header, const std::vector<std::uint16_t>& pixels);
  Settings settings() const;

  const std::string path_;
  const std::function<void()> lost_;
  mutable std::mutex mutex_;  // guards settings_
  Settings settings_;
  std::mutex running_mutex_;  // guards what start() and stop() do
  FrameSource source_;
  std::thread thread_;
  std::atomic<bool> stopping_{false};
};

}  // namespace slam::sim
