// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/depth_image.hpp"
#include "drivers/camera/usb_watch.hpp"
#include "drivers/device_status.hpp"

namespace slam {

struct OpenniConfig {
  std::string uri = {};           ///< of the device, or the path of a recording (.oni); empty: the first camera
  int width = 640, height = 480;  ///< [pixel]
  int rate = 30;                  ///< [Hz]
  std::string record = {};        ///< .oni file to record the depth stream to; empty: none. One that is there stays
  /// In place of `record`: asked once a second for the file, so that a recording may move on, end and begin.
  std::function<std::string()> record_to = {};
};

/// A camera that OpenNI2 finds.
struct CameraInfo {
  std::string uri, name;  ///< the name with its maker's
  std::string modes;      ///< of its depth: "640x480 at 30 Hz, ..."; empty: not known, another program has it
};
/// "URI (name, modes)"
std::string describe(const CameraInfo& camera);
/// All that there are now; waits half a second for the drivers of OpenNI2 to find them, and opens each for its modes.
std::vector<CameraInfo> listCameras();

/// Owns a depth camera, or a recording, through OpenNI2.
///
/// To be run by one thread: connect() until it succeeds, then poll() until it returns false. Waits on OpenNI2's event.
/// A camera that is unplugged or freezes is closed and opened anew; one that stays silent is reset on the USB. A
/// recording is played once, image by image without loss, at the pace of its stamps.
class OpenniCamera {
 public:
  /// @return why the image is of no use; none: it was used
  using Sink = std::function<Problem(const DepthImage&)>;
  using Clock = Timestamp (*)();

  /// @param usb that the camera is on; empty: libusb's
  OpenniCamera(const OpenniConfig& config, Clock now, Sink sink, std::unique_ptr<UsbWatch> usb = {});
  ~OpenniCamera();

  /// Looks for the camera, sets its mode, reads back what it made of it, and starts the stream.
  /// @return false with the reason in status()
  bool connect(const std::atomic<bool>& cancel);
  /// Waits up to `timeout` for an image and hands it to the sink.
  /// @return false when the connection is over (unplugged, or silent for longer than any image takes)
  bool poll(Duration timeout);
  void stop();
  /// A camera has just been plugged in: it is worth to connect at once.
  bool returned();

  DeviceStatus& status() { return status_; }
  /// A recording has been played to its end.
  bool finished() const { return finished_; }

 private:
  struct Library;
  struct Stream;
  bool startLibrary();
  void restartLibrary();
  bool findCamera(const std::atomic<bool>& cancel);
  void resetSilentCamera();
  bool fail(DeviceState state, const Problem& why);
  bool open(const std::atomic<bool>& cancel);
  bool setMode();
  Problem nameMissing();
  void startRecording();
  void noteRecording();
  void moveRecording();
  bool readImage();

  OpenniConfig config_;
  Clock now_;
  Sink sink_;
  DeviceStatus status_;
  std::unique_ptr<UsbWatch> usb_;
  std::unique_ptr<Library> library_;
  std::unique_ptr<Stream> stream_;
  int fruitless_ = 0;  // connections in a row without an image
  Timestamp next_restart_{}, next_reset_{};
  Duration restart_wait_, reset_wait_;
  DepthImage image_;
  bool finished_ = false;
};

}  // namespace slam
