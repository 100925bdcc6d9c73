// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/openni2/simulated_stream.hpp"

#include <algorithm>
#include <cstring>

namespace slam::sim {
namespace {

constexpr int kMaxMillimetres = 10000, kMaxTenths = 65534;  // as the device limits its two formats

/// The core asks with the exact size of a property's type.
template <typename Value>
OniStatus put(const Value& value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  return ONI_STATUS_OK;
}

template <typename Value>
bool take(Value& value, const void* data, int size) {
  if (size != static_cast<int>(sizeof value)) return false;
  std::memcpy(&value, data, sizeof value);
  return true;
}

bool inTenths(const OniVideoMode& mode) { return mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM; }

OniDepthPixel convert(std::uint16_t millimetres, bool tenths) {
  const int value = tenths ? 10 * millimetres : millimetres;
  return value > (tenths ? kMaxTenths : kMaxMillimetres) ? OniDepthPixel{0} : static_cast<OniDepthPixel>(value);
}

}  // namespace

SimulatedStream::Settings SimulatedStream::settings() const {
  const std::lock_guard lock(mutex_);
  return settings_;
}

OniBool SimulatedStream::isPropertySupported(int property) {
  switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
    case ONI_STREAM_PROPERTY_MAX_VALUE:
    case ONI_STREAM_PROPERTY_MIN_VALUE:
    case ONI_STREAM_PROPERTY_STRIDE:
    case ONI_STREAM_PROPERTY_MIRRORING:
      return TRUE;
    default:
      return FALSE;
  }
}

OniStatus SimulatedStream::getProperty(int property, void* data, int* size) {
  const Settings now = settings();
  const int columns = now.cropping.enabled ? now.cropping.width : now.mode.resolutionX;
  switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:
      return put(now.cropping, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return put(kDepthHorizontalFov, data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return put(kDepthVerticalFov, data, size);
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return put(now.mode, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return put(inTenths(now.mode) ? kMaxTenths : kMaxMillimetres, data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return put(int{0}, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return put(static_cast<int>(columns * static_cast<int>(sizeof(OniDepthPixel))), data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return put(now.mirrored, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus SimulatedStream::setMode(const OniVideoMode& mode) {
  const bool format =
      mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM || mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM;
  if (!format || mode.resolutionX <= 0 || mode.resolutionY <= 0 || mode.fps <= 0 ||
      !isDepthMode(static_cast<std::uint32_t>(mode.resolutionX), static_cast<std::uint32_t>(mode.resolutionY),
                   static_cast<std::uint32_t>(mode.fps))) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  const std::lock_guard running(running_mutex_);
  if (thread_.joinable()) return ONI_STATUS_OUT_OF_FLOW;
  const std::lock_guard lock(mutex_);
  settings_.mode = mode;
  settings_.cropping = {FALSE, 0, 0, mode.resolutionX, mode.resolutionY};
  return ONI_STATUS_OK;
}

OniStatus SimulatedStream::setCropping(const OniCropping& cropping) {
  const std::lock_guard lock(mutex_);
  const OniVideoMode& mode = settings_.mode;
  if (cropping.enabled &&
      (cropping.originX < 0 || cropping.originY < 0 || cropping.width <= 0 || cropping.height <= 0 ||
       cropping.width > mode.resolutionX - cropping.originX || cropping.height > mode.resolutionY - cropping.originY)) {
    return ONI_STATUS_BAD_PARAMETER;
  }
  settings_.cropping = cropping;
  return ONI_STATUS_OK;
}

OniStatus SimulatedStream::setProperty(int property, const void* data, int size) {
  OniStatus status = ONI_STATUS_BAD_PARAMETER;
  if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) {
    OniVideoMode mode;
    if (take(mode, data, size)) status = setMode(mode);
  } else if (property == ONI_STREAM_PROPERTY_CROPPING) {
    OniCropping cropping;
    if (take(cropping, data, size)) status = setCropping(cropping);
  } else if (property == ONI_STREAM_PROPERTY_MIRRORING) {
    OniBool mirrored = FALSE;
    if (take(mirrored, data, size)) {
      const std::lock_guard lock(mutex_);
      settings_.mirrored = mirrored != FALSE;
      status = ONI_STATUS_OK;
    }
  } else {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  if (status == ONI_STATUS_OK) raisePropertyChanged(property, data, size);
  return status;
}

OniStatus SimulatedStream::start() {
  const std::lock_guard running(running_mutex_);
  if (thread_.joinable()) return ONI_STATUS_OUT_OF_FLOW;
  const OniVideoMode mode = settings().mode;
  if (!source_.open(path_, {mode.resolutionX, mode.resolutionY, mode.fps})) {
    source_.close();
    lost_();
    return ONI_STATUS_NO_DEVICE;
  }
  stopping_ = false;
  thread_ = std::thread([this] { run(); });
  return ONI_STATUS_OK;
}

void SimulatedStream::stop() {
  const std::lock_guard running(running_mutex_);
  if (!thread_.joinable()) return;
  stopping_ = true;
  source_.interrupt();
  thread_.join();
  source_.close();
}

void SimulatedStream::run() {
  DepthFrameHeader header;
  std::vector<std::uint16_t> pixels;
  while (!stopping_ && source_.read(header, pixels)) deliver(header, pixels);
  source_.interrupt();  // a server that sends rubbish is not listened to any longer
  if (!stopping_) lost_();
}

void SimulatedStream::deliver(const DepthFrameHeader& header, const std::vector<std::uint16_t>& pixels) {
  const Settings now = settings();
  const int width = now.mode.resolutionX;
  const OniCropping area = now.cropping.enabled ? now.cropping : OniCropping{FALSE, 0, 0, width, now.mode.resolutionY};
  const int size = area.width * area.height * static_cast<int>(sizeof(OniDepthPixel));
  OniFrame* const frame = getServices().acquireFrame();
  if (frame == nullptr) return;
  if (frame->data == nullptr || frame->dataSize < size) return getServices().releaseFrame(frame);
  auto* out = static_cast<OniDepthPixel*>(frame->data);
  for (int v = area.originY; v < area.originY + area.height; ++v) {
    const std::uint16_t* const row = pixels.data() + static_cast<std::ptrdiff_t>(v) * width;
    for (int u = area.originX; u < area.originX + area.width; ++u) {
      *out++ = convert(row[now.mirrored ? width - 1 - u : u], inTenths(now.mode));
    }
  }
  frame->dataSize = size;
  frame->sensorType = ONI_SENSOR_DEPTH;
  frame->timestamp = header.time;
  frame->frameIndex = static_cast<int>(header.frame);
  frame->videoMode = now.mode;
  frame->width = area.width;
  frame->height = area.height;
  frame->croppingEnabled = area.enabled;
  frame->cropOriginX = area.originX;
  frame->cropOriginY = area.originY;
  frame->stride = area.width * static_cast<int>(sizeof(OniDepthPixel));
  raiseNewFrame(frame);
  getServices().releaseFrame(frame);
}

}  // namespace slam::sim
