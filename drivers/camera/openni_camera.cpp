// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/openni_camera.hpp"

#include <OpenNI.h>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <poll.h>
#include <set>
#include <utility>

#include "timing/device_clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kEnumeration = 500ms;
constexpr Duration kSilence = 900ms;  // without an image the camera has frozen
constexpr int kFruitless = 2;         // connections without an image, then the camera is reset
// Each start of OpenNI2 loses some memory (136 kB with Debian's drivers), and a camera that is reset again and again
// never comes to itself: both are done ever more seldom.
constexpr Duration kFirstRestart = 1s, kSeldomRestart = 3600s;
constexpr Duration kFirstReset = 10s, kSeldomReset = 600s;

/// Tells when a device is unplugged. Called by OpenNI2's own thread: it only sets a flag.
class Unplugged : public openni::OpenNI::DeviceDisconnectedListener {
 public:
  void onDeviceDisconnected(const openni::DeviceInfo*) override { happened_ = true; }
  bool take() { return happened_.exchange(false); }

 private:
  std::atomic<bool> happened_{false};
};

/// The name, or with -2, -3 ... in it where there is such a file: OpenNI2 would overwrite it.
std::string unusedName(const std::string& wanted) {
  const std::filesystem::path path(wanted);
  std::string name = wanted;
  for (int copy = 2; std::filesystem::exists(name); ++copy) {
    name = path.parent_path() / (path.stem().string() + "-" + std::to_string(copy) + path.extension().string());
  }
  return name;
}

/// "640x480 at 30 Hz, 320x240 at 30 and 60 Hz"
std::string modesOf(const openni::SensorInfo* sensor) {
  std::map<std::pair<int, int>, std::set<int>, std::greater<>> rates;  // by width and height
  for (int i = 0; sensor != nullptr && i < sensor->getSupportedVideoModes().getSize(); ++i) {
    const openni::VideoMode& mode = sensor->getSupportedVideoModes()[i];
    if (mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM)
      rates[{mode.getResolutionX(), mode.getResolutionY()}].insert(mode.getFps());
  }
  std::string text;
  for (const auto& [size, at] : rates) {
    text += (text.empty() ? "" : ", ") + std::to_string(size.first) + "x" + std::to_string(size.second) + " at ";
    for (auto rate = at.begin(); rate != at.end(); ++rate)
      text += (rate == at.begin() ? "" : " and ") + std::to_string(*rate);
    text += " Hz";
  }
  return text;
}

std::vector<CameraInfo> foundCameras() {
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  std::vector<CameraInfo> cameras;
  for (int i = 0; i < devices.getSize(); ++i) {
    const std::string vendor = devices[i].getVendor(), name = devices[i].getName();
    cameras.push_back({devices[i].getUri(), vendor + (vendor.empty() ? "" : " ") + name, ""});
  }
  for (CameraInfo& camera : cameras) {
    openni::Device device;
    if (device.open(camera.uri.c_str()) != openni::STATUS_OK) continue;
    camera.modes = modesOf(device.getSensorInfo(openni::SENSOR_DEPTH));
    device.close();
  }
  return cameras;
}

}  // namespace

std::string describe(const CameraInfo& camera) {
  return camera.uri + " (" + camera.name + (camera.modes.empty() ? "" : ", ") + camera.modes + ")";
}

std::vector<CameraInfo> listCameras() {
  std::vector<CameraInfo> cameras;
  if (openni::OpenNI::initialize() == openni::STATUS_OK) {
    for (Duration waited{0}; cameras.empty() && waited < kEnumeration; waited += 50ms) {
      cameras = foundCameras();
      if (cameras.empty()) ::poll(nullptr, 0, 50);
    }
  }
  openni::OpenNI::shutdown();
  return cameras;
}

/// OpenNI2 itself, which lives as long as it can: see above.
struct OpenniCamera::Library {
  Library() {
    openni::OpenNI::addDeviceDisconnectedListener(&unplugged);
    started = openni::OpenNI::initialize() == openni::STATUS_OK;
  }
  ~Library() {
    openni::OpenNI::removeDeviceDisconnectedListener(&unplugged);
    openni::OpenNI::shutdown();
  }
  Unplugged unplugged;
  bool started = false;
  bool waited = false;  // for its drivers' first words
};

struct OpenniCamera::Stream {
  ~Stream() {
    endRecording();
    stream.stop();
    stream.destroy();
    device.close();
  }

  void endRecording() {
    if (!recorder.isValid()) return;
    recorder.stop();
    recorder.destroy();
  }

  openni::Device device;
  openni::VideoStream stream;
  openni::VideoFrameRef frame;
  openni::Recorder recorder;
  std::string recorded;  // file that was wanted; empty: none
  Timestamp next_look{};
  bool mirrored = false;
  Problem note;         // what goes on beside a stream that is sound
  int frames_left = 0;  // of a recording
  DeviceClock clock;
  Timestamp last_image{};
  Timestamp first_shown{};  // of a recording
  Duration first_stamp{0};
};

OpenniCamera::OpenniCamera(const OpenniConfig& config, Clock now, Sink sink, std::unique_ptr<UsbWatch> usb)
    : config_(config),
      now_(now),
      sink_(std::move(sink)),
      usb_(usb ? std::move(usb) : makeUsbWatch(kPrimeSense)),
      restart_wait_(kFirstRestart),
      reset_wait_(kFirstReset) {}

OpenniCamera::~OpenniCamera() = default;

bool OpenniCamera::fail(DeviceState state, const Problem& why) {
  stream_.reset();
  status_.set(state, why);
  return false;
}

void OpenniCamera::stop() { stream_.reset(); }

bool OpenniCamera::returned() {
  const bool arrived = usb_->arrived();
  if (arrived) next_restart_ = now_();
  return arrived;
}

bool OpenniCamera::startLibrary() {
  if (!library_ && now_() >= next_restart_) restartLibrary();
  if (library_ && library_->started) return true;
  library_.reset();
  return fail(DeviceState::kFault, problem::kNoOpenni);
}

void OpenniCamera::restartLibrary() {
  library_.reset();
  library_ = std::make_unique<Library>();
  next_restart_ = now_() + restart_wait_;
  restart_wait_ = std::min(2 * restart_wait_, kSeldomRestart);
}

void OpenniCamera::resetSilentCamera() {
  const Timestamp now = now_();
  if (fruitless_ < kFruitless || now < next_reset_ || !usb_->present()) return;
  status_.set(DeviceState::kOpening, problem::kCameraReset);
  if (!usb_->reset()) return;  // the next attempt says what is the matter
  fruitless_ = 0;
  next_reset_ = now + reset_wait_;
  reset_wait_ = std::min(2 * reset_wait_, kSeldomReset);
}

bool OpenniCamera::connect(const std::atomic<bool>& cancel) {
  if (finished_) return fail(DeviceState::kAbsent, problem::kImagesOver);
  status_.setOpening(problem::kCameraSought);
  resetSilentCamera();
  if (!startLibrary()) return false;
  library_->unplugged.take();  // what happened to the one before
  ++fruitless_;                // until an image says otherwise
  if (cancel || !open(cancel) || !setMode()) return false;
  startRecording();
  if (stream_->stream.start() != openni::STATUS_OK) {
    return fail(DeviceState::kFault, problem::kCameraNotStarted);
  }
  if (stream_->recorder.isValid() && stream_->recorder.start() != openni::STATUS_OK) {
    return fail(DeviceState::kFault, problem::kImagesNotStored);
  }
  stream_->last_image = now_();
  noteRecording();
  const openni::DeviceInfo& info = stream_->device.getDeviceInfo();
  const openni::VideoMode mode = stream_->stream.getVideoMode();
  status_.identify(std::string(info.getVendor()) + " " + info.getName() + ", " + info.getUri() + ", " +
                   std::to_string(mode.getResolutionX()) + "x" + std::to_string(mode.getResolutionY()) + " at " +
                   std::to_string(mode.getFps()) + " Hz");
  status_.setOpening(problem::kCameraOpening);
  return true;
}

bool OpenniCamera::open(const std::atomic<bool>& cancel) {
  const bool recording = std::filesystem::path(config_.uri).extension() == ".oni";
  if (recording && !std::filesystem::exists(config_.uri)) {
    return fail(DeviceState::kAbsent, problem::kImagesMissing);
  }
  if (!recording && !findCamera(cancel)) return false;
  stream_ = std::make_unique<Stream>();
  const char* uri = config_.uri.empty() ? openni::ANY_DEVICE : config_.uri.c_str();
  if (stream_->device.open(uri) != openni::STATUS_OK) {
    if (const Problem missing = recording ? Problem() : nameMissing()) return fail(DeviceState::kAbsent, missing);
    return fail(DeviceState::kFault, recording ? problem::kImagesNotOpened : problem::kCameraNotOpened);
  }
  if (stream_->stream.create(stream_->device, openni::SENSOR_DEPTH) != openni::STATUS_OK) {
    return fail(DeviceState::kFault, problem::kCameraNoStream);
  }
  return true;
}

bool OpenniCamera::findCamera(const std::atomic<bool>& cancel) {
  openni::Array<openni::DeviceInfo> devices;
  // A driver may tell of its devices a little after it was started.
  for (const Timestamp end = now_() + (library_->waited ? Duration(0) : kEnumeration);;) {
    openni::OpenNI::enumerateDevices(&devices);
    if (devices.getSize() > 0) return true;
    if (now_() >= end || cancel) break;
    ::poll(nullptr, 0, 50);
  }
  library_->waited = true;
  fruitless_ = 0;  // there is none to be reset
  if (!usb_->present()) {
    restart_wait_ = kFirstRestart;
    return fail(DeviceState::kAbsent, problem::kCameraMissing);
  }
  // Without udev OpenNI2 does not notice a camera that came after it was started.
  if (now_() >= next_restart_) restartLibrary();
  return fail(DeviceState::kAbsent, problem::kCameraHidden);
}

/// @return none: the camera that is wanted is one of those that there are
Problem OpenniCamera::nameMissing() {
  if (config_.uri.empty()) return {};
  std::string list;
  for (const CameraInfo& camera : foundCameras()) {
    if (camera.uri == config_.uri) return {};
    list += (list.empty() ? "" : ", ") + describe(camera);
  }
  return Problem(problem::kCameraNameMissing, {}, {config_.uri, list});
}

/// Mode and mirroring are set and read back: their defaults differ between machines.
bool OpenniCamera::setMode() {
  openni::VideoStream& stream = stream_->stream;
  if (stream_->device.isFile()) {
    openni::PlaybackControl* playback = stream_->device.getPlaybackControl();
    if (playback == nullptr || playback->setSpeed(-1.0F) != openni::STATUS_OK ||
        playback->setRepeatEnabled(false) != openni::STATUS_OK) {
      return fail(DeviceState::kFault, problem::kImagesNotPlayed);
    }
    stream_->frames_left = playback->getNumberOfFrames(stream);
  } else {
    openni::VideoMode mode;
    mode.setResolution(config_.width, config_.height);
    mode.setFps(config_.rate);
    mode.setPixelFormat(openni::PIXEL_FORMAT_DEPTH_1_MM);
    if (stream.setVideoMode(mode) != openni::STATUS_OK) {
      const std::string wanted = std::to_string(config_.width) + "x" + std::to_string(config_.height) + " at " +
                                 std::to_string(config_.rate) + " Hz";
      return fail(DeviceState::kFault, Problem(problem::kCameraNoMode, {},
                                               {wanted, modesOf(stream_->device.getSensorInfo(openni::SENSOR_DEPTH))}));
    }
    const openni::VideoMode set = stream.getVideoMode();
    if (set.getResolutionX() != config_.width || set.getResolutionY() != config_.height ||
        set.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_1_MM) {
      return fail(DeviceState::kFault, problem::kCameraOtherMode);
    }
    stream.setMirroringEnabled(false);
  }
  stream_->mirrored = stream.getMirroringEnabled();  // where it cannot be switched off, the image is turned here
  const openni::VideoMode mode = stream.getVideoMode();
  if (mode.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_1_MM) {
    return fail(DeviceState::kFault, problem::kCameraOtherFormat);
  }
  const double horizontal = stream.getHorizontalFieldOfView(), vertical = stream.getVerticalFieldOfView();
  const auto plausible = [](double angle) { return angle > 0.1 && angle < 2.8; };
  if (!plausible(horizontal) || !plausible(vertical) || mode.getResolutionX() <= 0 || mode.getResolutionY() <= 0) {
    return fail(DeviceState::kFault, problem::kCameraNoView);
  }
  image_.intrinsics =
      DepthIntrinsics::fromFieldOfView(mode.getResolutionX(), mode.getResolutionY(), horizontal, vertical);
  image_.depth.assign(image_.intrinsics.pixels(), 0);
  return true;
}

void OpenniCamera::startRecording() {
  stream_->recorded = config_.record_to ? config_.record_to() : config_.record;
  if (stream_->recorded.empty() || stream_->device.isFile()) return;
  openni::Recorder& recorder = stream_->recorder;
  if (recorder.create(unusedName(stream_->recorded).c_str()) != openni::STATUS_OK) return;
  if (recorder.attach(stream_->stream, false) != openni::STATUS_OK) recorder.destroy();
}

void OpenniCamera::noteRecording() {
  const bool missing = !stream_->recorder.isValid() && !stream_->recorded.empty() && !stream_->device.isFile();
  stream_->note = missing ? problem::kImagesNotRecorded : Problem();
}

void OpenniCamera::moveRecording() {
  const Timestamp now = now_();
  if (!config_.record_to || now < stream_->next_look) return;
  stream_->next_look = now + 1s;
  if (config_.record_to() == stream_->recorded) return;
  stream_->endRecording();
  startRecording();
  if (stream_->recorder.isValid() && stream_->recorder.start() != openni::STATUS_OK) stream_->recorder.destroy();
  noteRecording();
}

bool OpenniCamera::poll(Duration timeout) {
  if (library_->unplugged.take()) return fail(DeviceState::kAbsent, problem::kCameraUnplugged);
  if (stream_->device.isFile()) {
    if (stream_->frames_left == 0) {
      finished_ = true;
      return fail(DeviceState::kAbsent, problem::kImagesOver);
    }
    --stream_->frames_left;
    return readImage();
  }
  moveRecording();
  openni::VideoStream* stream = &stream_->stream;
  int ready = -1;
  const int wait = static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count());
  if (openni::OpenNI::waitForAnyStream(&stream, 1, &ready, wait) == openni::STATUS_OK) return readImage();
  if (now_() - stream_->last_image < kSilence) return true;
  return fail(DeviceState::kFault, problem::kCameraFrozen);
}

bool OpenniCamera::readImage() {
  openni::VideoFrameRef& frame = stream_->frame;
  if (stream_->stream.readFrame(&frame) != openni::STATUS_OK || !frame.isValid()) {
    return fail(DeviceState::kFault, problem::kCameraUnread);
  }
  const Timestamp arrival = now_();
  const DepthIntrinsics& intrinsics = image_.intrinsics;
  const auto row = static_cast<std::size_t>(intrinsics.width) * sizeof(std::uint16_t);
  const bool expected =
      frame.getSensorType() == openni::SENSOR_DEPTH && frame.getWidth() == intrinsics.width &&
      frame.getHeight() == intrinsics.height && !frame.getCroppingEnabled() &&
      frame.getVideoMode().getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM &&
      static_cast<std::size_t>(frame.getStrideInBytes()) >= row &&
      static_cast<std::size_t>(frame.getDataSize()) >=
          static_cast<std::size_t>(frame.getStrideInBytes()) * (intrinsics.pixels() / intrinsics.width);
  if (!expected) {
    status_.rejects.fetch_add(1, std::memory_order_relaxed);
    frame.release();
    return true;
  }
  const auto* bytes = static_cast<const std::uint8_t*>(frame.getData());
  for (int v = 0; v < intrinsics.height; ++v) {
    const auto* from = reinterpret_cast<const std::uint16_t*>(bytes + v * frame.getStrideInBytes());
    auto to = image_.depth.begin() + static_cast<std::ptrdiff_t>(v) * intrinsics.width;
    stream_->mirrored ? std::reverse_copy(from, from + intrinsics.width, to)
                      : std::copy(from, from + intrinsics.width, to);
  }
  const Duration device = std::chrono::microseconds(frame.getTimestamp());
  frame.release();
  if (stream_->device.isFile()) {
    if (stream_->first_shown == Timestamp{}) {
      stream_->first_shown = arrival;
      stream_->first_stamp = device;
    }
    image_.stamp = stream_->first_shown + (device - stream_->first_stamp);
    while (now_() < image_.stamp) ::poll(nullptr, 0, 1 + static_cast<int>((image_.stamp - now_()) / 1ms));
  } else {
    image_.stamp = stream_->clock.stamp(device, arrival);
  }
  stream_->last_image = arrival;
  fruitless_ = 0;
  restart_wait_ = kFirstRestart;
  status_.countSample(image_.stamp);
  const Problem problem = sink_(image_);
  status_.set(DeviceState::kStreaming, problem ? problem : stream_->note);
  if (problem) status_.rejects.fetch_add(1, std::memory_order_relaxed);
  return true;
}

}  // namespace slam
