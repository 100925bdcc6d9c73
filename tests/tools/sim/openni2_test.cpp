// SPDX-License-Identifier: BSD-3-Clause
// The OpenNI2 driver of the simulated camera, used as a program uses any camera. Wants LD_LIBRARY_PATH as
// tools/sim/openni2 says; ctest sets it.
#include <OpenNI.h>
#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <mutex>
#include <optional>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>

#include "support/simulated/camera.hpp"
#include "tools/sim/depth/depth_wire.hpp"

// OpenNI2 leaks a little of its own, and its locks are half the story to ThreadSanitizer: it is not instrumented.
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }
extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }

namespace slam::sim::openni2_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
constexpr auto kPatience = 10s;
#if defined(__SANITIZE_THREAD__)
constexpr int kMostFrames = 300;  // for 20 that are read: the sanitizer slows the reader down, not the camera
#else
constexpr int kMostFrames = 60;
#endif

/// Counts the camera's comings and goings; must be made before OpenNI is initialised.
class Presence : public openni::OpenNI::DeviceConnectedListener, public openni::OpenNI::DeviceDisconnectedListener {
 public:
  Presence() {
    openni::OpenNI::addDeviceConnectedListener(this);
    openni::OpenNI::addDeviceDisconnectedListener(this);
  }
  ~Presence() {
    openni::OpenNI::removeDeviceConnectedListener(this);
    openni::OpenNI::removeDeviceDisconnectedListener(this);
  }
  void onDeviceConnected(const openni::DeviceInfo*) override { count(connected_); }
  void onDeviceDisconnected(const openni::DeviceInfo*) override { count(disconnected_); }
  bool waitFor(int connected, int disconnected) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return connected_ >= connected && disconnected_ >= disconnected; });
  }

 private:
  void count(int& counter) {
    const std::lock_guard lock(mutex_);
    ++counter;
    changed_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  int connected_ = 0, disconnected_ = 0;
};

class SimulatedXtion : public testing::Test, protected test::SimulatedCamera {
 protected:
  ~SimulatedXtion() override {
    stream_.destroy();
    device_.close();
    openni::OpenNI::shutdown();
  }

  void openCamera() {
    simulate();
    ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
    ASSERT_TRUE(presence_.waitFor(1, 0));
    openAgain();
  }
  void openAgain() {
    ASSERT_EQ(device_.open(openni::ANY_DEVICE), openni::STATUS_OK) << openni::OpenNI::getExtendedError();
    ASSERT_EQ(stream_.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  }
  openni::Status setMode(int width, int height, int rate, openni::PixelFormat format) {
    openni::VideoMode mode;
    mode.setResolution(width, height);
    mode.setFps(rate);
    mode.setPixelFormat(format);
    return stream_.setVideoMode(mode);
  }
  bool read(openni::VideoFrameRef& frame, openni::VideoStream* stream) {
    int ready = -1;
    return openni::OpenNI::waitForAnyStream(&stream, 1, &ready, 5000) == openni::STATUS_OK &&
           stream->readFrame(&frame) == openni::STATUS_OK;
  }
  bool read(openni::VideoFrameRef& frame) { return read(frame, &stream_); }

  Presence presence_;
  openni::Device device_;
  openni::VideoStream stream_;
};

std::vector<std::uint16_t> pixels(const openni::VideoFrameRef& frame) {
  const auto* data = static_cast<const std::uint16_t*>(frame.getData());
  return {data, data + frame.getWidth() * frame.getHeight()};
}

/// Median of the data around a pixel [the frame's unit].
int depthAt(const openni::VideoFrameRef& frame, int u0, int v0) {
  std::vector<std::uint16_t> values;
  const auto* data = static_cast<const std::uint16_t*>(frame.getData());
  for (int v = v0 - 8; v < v0 + 8; ++v) {
    for (int u = u0 - 8; u < u0 + 8; ++u) {
      if (const std::uint16_t depth = data[v * frame.getWidth() + u]) values.push_back(depth);
    }
  }
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

constexpr int kWall = 3050, kBox = 2050;       // [mm]
constexpr int kBoxLeft = 70, kMirrored = 250;  // [px] columns of the box at 320

TEST_F(SimulatedXtion, StreamsWhatTheCameraSees) {
  openCamera();
  EXPECT_STREQ(device_.getDeviceInfo().getVendor(), "SlamSim");
  EXPECT_STREQ(device_.getDeviceInfo().getName(), "simulated Xtion");
  EXPECT_EQ(device_.getDeviceInfo().getUri(), "slam-sim:" + (directory_ / "depth").string());
  EXPECT_EQ(stream_.getSensorInfo().getSupportedVideoModes().getSize(), 6);
  EXPECT_TRUE(stream_.getMirroringEnabled());  // as the real device's code
  EXPECT_FLOAT_EQ(stream_.getHorizontalFieldOfView(), 1.0226F);
  EXPECT_FLOAT_EQ(stream_.getVerticalFieldOfView(), 0.7966F);
  EXPECT_EQ(stream_.getMaxPixelValue(), 10000);
  ASSERT_EQ(setMode(320, 240, 30, openni::PIXEL_FORMAT_DEPTH_1_MM), openni::STATUS_OK);
  ASSERT_EQ(stream_.setMirroringEnabled(false), openni::STATUS_OK);
  EXPECT_FALSE(stream_.getMirroringEnabled());
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  int last = 0;
  std::uint64_t last_time = 0;
  for (int i = 0; i < 20; ++i) {
    openni::VideoFrameRef frame;
    ASSERT_TRUE(read(frame));
    ASSERT_EQ(frame.getWidth(), 320);
    ASSERT_EQ(frame.getHeight(), 240);
    ASSERT_EQ(frame.getDataSize(), 320 * 240 * 2);
    EXPECT_NEAR(depthAt(frame, 160, 100), kWall, 60);
    EXPECT_NEAR(depthAt(frame, kBoxLeft, 100), kBox, 40);
    EXPECT_NEAR(depthAt(frame, kMirrored, 100), kWall, 60);
    ASSERT_GT(frame.getFrameIndex(), last);
    if (i > 0) {
      EXPECT_NEAR(static_cast<double>(frame.getTimestamp() - last_time), (frame.getFrameIndex() - last) * 33333.3, 2.0);
    }
    last = frame.getFrameIndex();
    last_time = frame.getTimestamp();
  }
  EXPECT_LT(last, kMostFrames);  // and few are lost
}

TEST_F(SimulatedXtion, MirrorsCropsAndCountsTenthsOfMillimetresWhenAsked) {
  openCamera();
  ASSERT_EQ(setMode(320, 240, 60, openni::PIXEL_FORMAT_DEPTH_100_UM), openni::STATUS_OK);
  EXPECT_EQ(stream_.getMaxPixelValue(), 65534);
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  openni::VideoFrameRef frame;
  ASSERT_TRUE(read(frame));
  EXPECT_NEAR(depthAt(frame, kMirrored, 100), 10 * kBox, 400);
  EXPECT_NEAR(depthAt(frame, kBoxLeft, 100), 10 * kWall, 600);
  EXPECT_NE(setMode(640, 480, 30, openni::PIXEL_FORMAT_DEPTH_1_MM), openni::STATUS_OK);  // while it runs
  stream_.stop();
  ASSERT_EQ(setMode(640, 480, 30, openni::PIXEL_FORMAT_DEPTH_1_MM), openni::STATUS_OK);
  EXPECT_NE(setMode(640, 480, 60, openni::PIXEL_FORMAT_DEPTH_1_MM), openni::STATUS_OK);  // not served
  ASSERT_EQ(stream_.setCropping(400, 100, 200, 50), openni::STATUS_OK);
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  ASSERT_TRUE(read(frame));
  EXPECT_EQ(frame.getWidth(), 200);
  EXPECT_EQ(frame.getHeight(), 50);
  EXPECT_EQ(frame.getCropOriginX(), 400);
  EXPECT_EQ(frame.getStrideInBytes(), 400);
  EXPECT_NEAR(depthAt(frame, 100, 25), kBox, 40);
}

TEST_F(SimulatedXtion, IsRecordedAndPlayedBackWithoutLoss) {
  openCamera();
  ASSERT_EQ(setMode(320, 240, 30, openni::PIXEL_FORMAT_DEPTH_1_MM), openni::STATUS_OK);
  ASSERT_EQ(stream_.setMirroringEnabled(false), openni::STATUS_OK);
  const fs::path file = directory_ / "record.oni";
  openni::Recorder recorder;
  ASSERT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
  ASSERT_EQ(recorder.attach(stream_, false), openni::STATUS_OK);
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  ASSERT_EQ(recorder.start(), openni::STATUS_OK);
  std::vector<std::vector<std::uint16_t>> seen;
  openni::VideoFrameRef frame;
  while (seen.size() < 20) {
    ASSERT_TRUE(read(frame));
    seen.push_back(pixels(frame));  // no two are the same: each has its noise
  }
  recorder.stop();
  stream_.stop();
  recorder.destroy();
  frame.release();

  openni::Device player;
  ASSERT_EQ(player.open(file.c_str()), openni::STATUS_OK) << openni::OpenNI::getExtendedError();
  openni::VideoStream played;
  ASSERT_EQ(played.create(player, openni::SENSOR_DEPTH), openni::STATUS_OK);
  EXPECT_FLOAT_EQ(played.getHorizontalFieldOfView(), 1.0226F);
  EXPECT_FALSE(played.getMirroringEnabled());
  ASSERT_EQ(player.getPlaybackControl()->setSpeed(-1.0F), openni::STATUS_OK);
  ASSERT_EQ(player.getPlaybackControl()->setRepeatEnabled(false), openni::STATUS_OK);
  const int frames = player.getPlaybackControl()->getNumberOfFrames(played);
  ASSERT_EQ(played.start(), openni::STATUS_OK);
  ASSERT_GE(frames, 19);  // the recorder works behind: what it begins and ends with may be a frame off
  // OpenNI2's 16z codec may get the last pixels of a frame wrong by a few millimetres.
  constexpr std::ptrdiff_t kCompared = 320 * 240 - 16;
  std::size_t found = 0;
  auto expected = seen.begin();
  for (int i = 0; i < frames; ++i) {
    ASSERT_TRUE(read(frame, &played)) << i << " of " << frames;
    const auto same = [&, now = pixels(frame)](const std::vector<std::uint16_t>& then) {
      return std::equal(then.begin(), then.begin() + kCompared, now.begin());
    };
    const auto place = std::find_if(expected, seen.end(), same);  // in order; the reader may have missed a frame
    if (place == seen.end()) continue;
    expected = std::next(place);
    ++found;
  }
  EXPECT_GE(found + 1, seen.size());
  frame.release();
  played.stop();
  played.destroy();
  player.close();
}

TEST_F(SimulatedXtion, ComesAndGoesWithTheSimulator) {
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  EXPECT_NE(device_.open(openni::ANY_DEVICE), openni::STATUS_OK);
  simulate();
  ASSERT_TRUE(presence_.waitFor(1, 0));
  openAgain();
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  openni::VideoFrameRef frame;
  ASSERT_TRUE(read(frame));
  simulator_->signal(SIGKILL);
  ASSERT_TRUE(presence_.waitFor(1, 1));
  frame.release();
  stream_.stop();
  stream_.destroy();
  device_.close();
  simulator_.reset();
  simulate();
  ASSERT_TRUE(presence_.waitFor(2, 1));
  openAgain();
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  ASSERT_TRUE(read(frame));
  simulator_->signal(SIGTERM);
  ASSERT_EQ(simulator_->wait(kPatience), 0);
  ASSERT_TRUE(presence_.waitFor(2, 2));
}

TEST_F(SimulatedXtion, SurvivesBeingStartedAndStoppedAtAnyMoment) {
  openCamera();
  for (int i = 0; i < 40; ++i) {
    if (i % 10 == 9) {
      stream_.destroy();
      if (i % 20 == 19) device_.close();
      if (i % 20 == 19) {
        openAgain();
      } else {
        ASSERT_EQ(stream_.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
      }
      ASSERT_EQ(setMode(320, 240, 60, openni::PIXEL_FORMAT_DEPTH_1_MM), openni::STATUS_OK);
    }
    ASSERT_EQ(stream_.start(), openni::STATUS_OK) << i;
    openni::VideoFrameRef frame;
    for (int frames = 0; frames < i % 3; ++frames) ASSERT_TRUE(read(frame)) << i;
    if (i % 10 != 8) stream_.stop();  // else destroyed while it runs
  }
}

/// Serves the socket and answers every request with the same bytes.
class Impostor {
 public:
  Impostor(const fs::path& path, std::vector<std::uint8_t> answer) : answer_(std::move(answer)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.native().copy(address.sun_path, sizeof address.sun_path - 1);
    listener_ = socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 8), 0);
    thread_ = std::thread([this] { run(); });
  }
  ~Impostor() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }

 private:
  void run() {
    for (int client = accept(listener_, nullptr, nullptr); client >= 0; client = accept(listener_, nullptr, nullptr)) {
      DepthModeRequest request;
      if (recv(client, &request, sizeof request, MSG_WAITALL) == static_cast<ssize_t>(sizeof request)) {
        send(client, answer_.data(), answer_.size(), MSG_NOSIGNAL);
        recv(client, &request, 1, 0);  // returns when the driver closes
      }
      close(client);
    }
  }
  std::vector<std::uint8_t> answer_;
  int listener_;
  std::thread thread_;
};

TEST_F(SimulatedXtion, ClosesASocketThatSendsRubbish) {
  const Impostor impostor(directory_ / "depth", std::vector<std::uint8_t>(1000, 0xA5));
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  ASSERT_TRUE(presence_.waitFor(1, 0));
  openAgain();
  ASSERT_EQ(stream_.start(), openni::STATUS_OK);
  EXPECT_TRUE(presence_.waitFor(1, 1));
  stream_.stop();
  stream_.destroy();
  device_.close();
}

}  // namespace
}  // namespace slam::sim::openni2_test
