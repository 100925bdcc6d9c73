// SPDX-License-Identifier: BSD-3-Clause
// The driver on the real OpenNI2, whose camera is slam-sim's. Wants LD_LIBRARY_PATH as tools/sim/openni2 says; ctest
// sets it.
#include "drivers/camera/openni_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/camera/fake_usb.hpp"
#include "runtime/clock.hpp"
#include "runtime/process_usage.hpp"
#include "support/simulated/camera.hpp"

// OpenNI2 leaks a little of its own, and its locks are half the story to ThreadSanitizer: it is not instrumented.
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }
extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }

namespace slam::openni_camera_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
constexpr Duration kPatience = 30s;
#else
constexpr bool kSanitized = false;
constexpr Duration kPatience = 10s;
#endif

class OpenniCameraTest : public testing::Test, protected test::SimulatedCamera {
 protected:
  ~OpenniCameraTest() override { camera_.stop(); }

  /// Runs the driver as its thread does, until the condition holds. @return false when it does not in time
  template <typename Condition>
  bool runUntil(Condition&& condition, Duration limit = kPatience) {
    const std::atomic<bool> cancel{false};
    for (const Timestamp end = monotonicNow() + limit; !condition();) {
      if (monotonicNow() > end) return false;
      connected_ = connected_ ? camera_.poll(50ms) : camera_.connect(cancel);
      connections_ += connected_;
    }
    return true;
  }
  bool seesImages() {
    const int before = images_;
    return runUntil([&] { return images_ > before + 3; });
  }
  std::string reason() { return camera_.status().problem().words(); }

  test::FakeUsb* usb_ = new test::FakeUsb;  // the camera's
  int images_ = 0, connections_ = 0;
  Problem verdict_;
  DepthImage last_;
  OpenniCamera camera_{{.width = 320, .height = 240},
                       &monotonicNow,
                       [this](const DepthImage& image) {
                         ++images_;
                         last_ = image;
                         return verdict_;
                       },
                       std::unique_ptr<UsbWatch>(usb_)};
  bool connected_ = false;
};

TEST_F(OpenniCameraTest, HandsOutImagesAsTheCameraSeesThem) {
  simulate();
  ASSERT_TRUE(seesImages()) << reason();
  EXPECT_EQ(camera_.status().state, DeviceState::kStreaming);
  EXPECT_EQ(last_.depth.size(), 320U * 240U);
  EXPECT_NEAR(last_.depth[100 * 320 + 160], 3050, 100) << "the wall ahead";
  EXPECT_NEAR(last_.depth[100 * 320 + 70], 2050, 60) << "the box on the left: not mirrored";
  EXPECT_LT(monotonicNow() - last_.stamp, 2s);
  EXPECT_EQ(usb_->resets, 0);
}

TEST_F(OpenniCameraTest, ReportsWhatItsUserFoundWrongWithAnImage) {
  simulate();
  verdict_ = problem::kImagesEmpty;
  ASSERT_TRUE(seesImages());
  EXPECT_TRUE(camera_.status().problem().is(problem::kImagesEmpty));
  EXPECT_GE(camera_.status().rejects, images_);
  verdict_ = {};
  ASSERT_TRUE(seesImages());
  EXPECT_EQ(reason(), "");
}

TEST_F(OpenniCameraTest, NamesTheCamerasThatThereAreWhereTheWantedOneIsNot) {
  simulate();
  const std::atomic<bool> cancel{false};
  OpenniCamera yesterdays{{.uri = "slam-sim:/gone", .width = 320, .height = 240},
                          &monotonicNow,
                          [](const DepthImage&) { return Problem(); },
                          std::make_unique<test::FakeUsb>()};
  const Timestamp end = monotonicNow() + kPatience;  // until OpenNI2 has found the camera that there is
  do EXPECT_FALSE(yesterdays.connect(cancel));
  while (yesterdays.status().problem().words().find("/gone") == std::string::npos && monotonicNow() < end);
  EXPECT_EQ(yesterdays.status().state, DeviceState::kAbsent);
  EXPECT_THAT(yesterdays.status().problem().words(),
              testing::AllOf(HasSubstr("no camera slam-sim:/gone (depth.uri)"), HasSubstr("there is slam-sim:"),
                             HasSubstr("320x240 at"), HasSubstr("set depth.uri")));
}

TEST_F(OpenniCameraTest, NamesTheModesOfACameraThatDoesNotOfferTheWantedOne) {
  simulate();
  const std::atomic<bool> cancel{false};
  OpenniCamera wide{{.width = 1024, .height = 768},
                    &monotonicNow,
                    [](const DepthImage&) { return Problem(); },
                    std::make_unique<test::FakeUsb>()};
  const Timestamp end = monotonicNow() + kPatience;
  do EXPECT_FALSE(wide.connect(cancel));
  while (wide.status().problem().words().find("1024") == std::string::npos && monotonicNow() < end);
  EXPECT_THAT(wide.status().problem().words(),
              testing::AllOf(HasSubstr("does not offer 1024x768 at 30 Hz"), HasSubstr("320x240 at")));
}

TEST_F(OpenniCameraTest, ReportsWhatItIs) {
  simulate();
  ASSERT_TRUE(seesImages()) << reason();
  EXPECT_THAT(camera_.status().identity.load(), testing::AllOf(HasSubstr("slam-sim:"), HasSubstr("320x240 at 30 Hz")));
  EXPECT_EQ(camera_.status().identified.load(), 1) << "once for the connection";
}

TEST_F(OpenniCameraTest, ComesBackAfterItWasUnplugged) {
  simulate();
  ASSERT_TRUE(seesImages());
  inject("unplug 1");
  const Timestamp pulled = monotonicNow();
  ASSERT_TRUE(runUntil([&] { return !connected_; }));
  EXPECT_LT(monotonicNow() - pulled, kPatience / 5) << "noticed in time";
  EXPECT_NE(camera_.status().state, DeviceState::kStreaming);
  usb_->on_bus = false;
  ASSERT_TRUE(runUntil([&] { return reason() == "no camera found: check plug and power"; })) << reason();
  inject("unplug 0");
  usb_->on_bus = true;
  ASSERT_TRUE(seesImages()) << reason();
  EXPECT_EQ(usb_->resets, 0);
}

TEST_F(OpenniCameraTest, OpensAFrozenCameraAnewAndResetsOneThatStaysSilent) {
  simulate();
  ASSERT_TRUE(seesImages());
  usb_->at_reset = [this] { inject("freeze 0"); };
  inject("freeze 1");
  ASSERT_TRUE(runUntil([&] { return !connected_; }));
  EXPECT_THAT(reason(), HasSubstr("frozen"));
  EXPECT_EQ(usb_->resets, 0) << "the last step, not the first";
  const int before = connections_;
  ASSERT_TRUE(seesImages()) << reason();
  EXPECT_EQ(usb_->resets, 1);
  EXPECT_GE(connections_ - before, 2);
}

TEST_F(OpenniCameraTest, ResetsOnceInAWhileOnly) {
  simulate();
  ASSERT_TRUE(seesImages());
  inject("freeze 1");
  const int before = connections_;
  int silences = 0;
  ASSERT_TRUE(runUntil([&] { return (silences += !connected_) >= 5 && connections_ > before + 3; }, 3 * kPatience));
  EXPECT_EQ(usb_->resets, 1);
  inject("freeze 0");
  EXPECT_TRUE(seesImages());
}

TEST_F(OpenniCameraTest, ReportsThatACameraIsThereWhichOpenNI2DoesNotFind) {
  ASSERT_TRUE(runUntil([&] { return reason().find("udev") != std::string::npos; })) << reason();
  EXPECT_EQ(camera_.status().state, DeviceState::kAbsent);
  EXPECT_EQ(usb_->resets, 0);
}

TEST_F(OpenniCameraTest, FindsACameraThatComesAfterTheStart) {
  usb_->on_bus = false;
  ASSERT_TRUE(runUntil([&] { return reason().find("no camera") != std::string::npos; })) << reason();
  simulate();
  ASSERT_TRUE(seesImages()) << reason();
}

TEST_F(OpenniCameraTest, GrowsNoMemoryWhileThereIsNoCamera) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer keeps what is freed";
  const std::atomic<bool> cancel{false};
  const auto attempts = [&](int count) {
    for (int i = 0; i < count; ++i) EXPECT_FALSE(camera_.connect(cancel));
  };
  for (const bool on_bus : {false, true}) {
    usb_->on_bus = on_bus;
    attempts(100);
    const double before = residentMegabytes();
    attempts(400);
    EXPECT_LT(residentMegabytes() - before, 1.0);  // a start of OpenNI2 at each attempt would cost 4 MB
  }
}

TEST_F(OpenniCameraTest, ResumesAtOnceWhenTheBusReportsAnArrival) {
  EXPECT_FALSE(camera_.returned());
  usb_->plugged_in = true;
  EXPECT_TRUE(camera_.returned());
  EXPECT_FALSE(camera_.returned()) << "told once";
}

}  // namespace
}  // namespace slam::openni_camera_test
