// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_server.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <system_error>
#include <unistd.h>

#include "runtime/worker.hpp"
#include "tools/sim/openni2/frame_source.hpp"

namespace slam::sim::depth_server_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class DepthServerTest : public testing::Test {
 protected:
  DepthServerTest() { worker_.start(); }
  ~DepthServerTest() override { worker_.stop(); }

  static World wallAhead() {
    World world;
    world.addWall({3.05, -9.0}, {3.05, 9.0});
    return world;
  }

  const fs::path path_ = fs::path(testing::TempDir()) / ("depth_server_" + std::to_string(getpid()));
  DepthServer server_{path_, wallAhead(), 1, [](Timestamp) { return std::optional(DepthViewpoint{}); }};
  Worker worker_{{.name = "depth"}, [this] { server_.serve(20ms); }};
  DepthFrameHeader header_;
  std::vector<std::uint16_t> pixels_;
};

TEST_F(DepthServerTest, ServesOneClientAfterTheOther) {
  FrameSource first, second;
  ASSERT_TRUE(first.open(path_, {320, 240, 60}));
  ASSERT_TRUE(first.read(header_, pixels_));
  ASSERT_TRUE(second.open(path_, {640, 480, 30}));
  EXPECT_TRUE(isServed(path_));
  for (std::uint32_t frame = 2; frame < 5; ++frame) {
    ASSERT_TRUE(first.read(header_, pixels_));
    EXPECT_GE(header_.frame, frame);
  }
  EXPECT_EQ(pixels_.size(), 320U * 240U);
  first.close();
  ASSERT_TRUE(second.read(header_, pixels_));
  EXPECT_EQ(header_.frame, 1U);
  EXPECT_EQ(pixels_.size(), 640U * 480U);
}

TEST_F(DepthServerTest, SendsAwayWhoAsksForWhatItHasNot) {
  FrameSource greedy, modest;
  ASSERT_TRUE(greedy.open(path_, {640, 480, 60}));
  EXPECT_FALSE(greedy.read(header_, pixels_));
  ASSERT_TRUE(modest.open(path_, {320, 240, 30}));
  EXPECT_TRUE(modest.read(header_, pixels_));
}

TEST_F(DepthServerTest, IsNotKeptUpByAClientThatDoesNotRead) {
  FrameSource slow;
  ASSERT_TRUE(slow.open(path_, {640, 480, 30}));
  ASSERT_TRUE(slow.read(header_, pixels_));
  const std::uint64_t ticks = worker_.ticks();
  const auto deadline = std::chrono::steady_clock::now() + 20s;
  while (worker_.ticks() < ticks + 400 && std::chrono::steady_clock::now() < deadline) usleep(1000);
  std::uint32_t before = header_.frame;
  int gaps = 0;
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(slow.read(header_, pixels_));
    gaps += header_.frame > before + 1;
    before = header_.frame;
  }
  EXPECT_GE(gaps, 1);  // frames are lost, and none is torn
}

TEST(DepthServer, ComesBackWhenPluggedInAgain) {
  const fs::path path = fs::path(testing::TempDir()) / ("depth_plug_" + std::to_string(getpid()));
  DepthServer server(path, World{}, 1, [](Timestamp) { return std::optional<DepthViewpoint>(); });
  ASSERT_TRUE(server.inject("unplug", 1));
  EXPECT_FALSE(isServed(path));
  server.serve(1ms);
  ASSERT_TRUE(server.inject("unplug", 0));
  EXPECT_TRUE(isServed(path));
  EXPECT_FALSE(server.inject("burn", 1));
}

TEST(DepthServer, LeavesNoSocketBehindAndTakesTheOneThatWasLeft) {
  const fs::path path = fs::path(testing::TempDir()) / ("depth_left_" + std::to_string(getpid()));
  const auto nowhere = [](Timestamp) { return std::optional<DepthViewpoint>(); };
  {
    const DepthServer killed(path, World{}, 1, nowhere);
    const DepthServer server(path, World{}, 1, nowhere);
    EXPECT_TRUE(isServed(path));
  }
  EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(isServed(path));
  EXPECT_THROW(DepthServer(path / std::string(100, 'x') / "depth", World{}, 1, nowhere), std::system_error);
}

}  // namespace
}  // namespace slam::sim::depth_server_test
