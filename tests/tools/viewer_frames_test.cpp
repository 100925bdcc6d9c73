// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/viewer_frames.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tools/files.hpp"

namespace slam::viewer_frames_test {
namespace {

using test::contentOf;
using test::Folder;
using test::refusalOf;

constexpr double kResolution = 0.1;
constexpr int kMargin = 5;  // [cells]

/// A free square of 4 m with its lower left corner at the origin.
MapImage freeSquare() {
  MapImage map{.width = 40, .height = 40, .resolution = kResolution, .cells = {}};
  map.cells.assign(40 * 40, MapImage::kFree);
  return map;
}

/// Colour at a place in map, in a picture of freeSquare() that needed no more room for the robot.
Rgb colourAt(const ColourImage& image, double x, double y) {
  const double pixels = image.width / ((40 + 2 * kMargin) * kResolution);  // per metre
  return image.at(static_cast<int>(pixels * (x + kMargin * kResolution)),
                  image.height - 1 - static_cast<int>(pixels * (y + kMargin * kResolution)));
}

TEST(DrawScene, PutsRobotScanPathAndClosuresWhereTheyAre) {
  const std::vector<Pose2> keyframes = {{0.5, 0.5, 0.0}, {3.5, 0.5, 0.0}, {3.5, 3.5, 0.0}};
  std::vector<Edge> edges(2);
  edges[0].to = 1;
  edges[1].to = 2;
  edges[1].kind = EdgeKind::kLoopClosure;
  const std::vector<Eigen::Vector2d> scan = {{1.0, 0.0}};
  const double kQuarter = std::acos(0.0);
  ViewerScene scene{.T_map_base = {1.0, 2.5, kQuarter}, .scan = scan, .keyframes = keyframes, .edges = edges};
  ColourImage image = drawScene(freeSquare(), scene);
  EXPECT_EQ(colourAt(image, 1.0, 2.5), kRobotColour);
  EXPECT_EQ(colourAt(image, 1.0, 2.75), kRobotColour) << "its nose, ahead";
  EXPECT_NE(colourAt(image, 1.0, 2.25), kRobotColour) << "behind it";
  EXPECT_EQ(colourAt(image, 1.0, 3.5), kScanColour) << "a metre ahead";
  EXPECT_EQ(colourAt(image, 2.0, 0.5), kPathColour);
  EXPECT_EQ(colourAt(image, 2.0, 2.0), kClosureColour);
  EXPECT_EQ(colourAt(image, 2.7, 1.2), (Rgb{MapImage::kFree, MapImage::kFree, MapImage::kFree}));
  edges[1].revoked = true;
  image = drawScene(freeSquare(), scene);
  EXPECT_NE(colourAt(image, 2.0, 2.0), kClosureColour) << "taken back";
}

TEST(DrawScene, IsLargeEnoughToSeeAndGrowsWithTheMapAndTheRobotsWay) {
  const ColourImage small = drawScene(freeSquare(), {.T_map_base = {2.0, 2.0, 0.0}});
  EXPECT_EQ(small.width, 8 * (40 + 2 * kMargin));
  EXPECT_EQ(small.height, small.width);
  const ColourImage wide = drawScene(freeSquare(), {.T_map_base = {-16.0, 2.0, 0.0}});
  EXPECT_EQ(wide.width, 6 * (40 + 160 + 2 * kMargin));
  EXPECT_EQ(wide.height, 6 * (40 + 2 * kMargin));
  EXPECT_NE(std::find(wide.pixels.begin(), wide.pixels.end(), kRobotColour), wide.pixels.end());
  EXPECT_EQ(drawScene(freeSquare(), {.T_map_base = {500.0, 2.0, 0.0}}).height, 40 + 2 * kMargin) << "a pixel a cell";
}

TEST(ViewerFrames, AreNumberedAndIndexed) {
  const Folder folder;
  ViewerFrames frames(folder / "a/b", 2.0);
  EXPECT_TRUE(frames.due(0.0));
  const std::vector<Pose2> keyframes(3);
  frames.write(freeSquare(), {.log_s = 0.5, .T_map_base = {1.0, 2.0, 0.5}, .keyframes = keyframes});
  EXPECT_FALSE(frames.due(1.9));
  EXPECT_TRUE(frames.due(2.0));
  frames.write(freeSquare(), {.log_s = 7.0, .T_map_base = {1.0, 2.0, 0.5}});
  EXPECT_FALSE(frames.due(7.9)) << "missed ones are left out";
  EXPECT_TRUE(frames.due(8.0));
  frames.close();
  EXPECT_EQ(contentOf(folder / "a/b/index.csv"),
            "frame,log_s,x,y,theta,keyframes,loop_closures\n"
            "frame-000000.png,0.500,1.0000,2.0000,0.50000,3,0\n"
            "frame-000001.png,7.000,1.0000,2.0000,0.50000,0,0\n");
  EXPECT_THAT(contentOf(folder / "a/b/frame-000001.png"), testing::StartsWith("\x89PNG"));
}

TEST(ViewerFrames, ReplaceThoseOfAnEarlierRunAndNothingElse) {
  const Folder folder;
  folder.write("frame-000007.png", "old");
  folder.write("frame-7.png", "not ours");
  ViewerFrames frames(folder / "", 1.0);
  EXPECT_FALSE(std::filesystem::exists(folder / "frame-000007.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "frame-7.png"));
}

TEST(ViewerFrames, ReportWhichFolderTheyCannotWrite) {
  const Folder folder;
  folder.write("file", "in the way");
  for (const char* name : {"file", "file/below"}) {
    EXPECT_THAT(refusalOf([&] { ViewerFrames frames(folder / name, 1.0); }), testing::HasSubstr(name));
  }
}

}  // namespace
}  // namespace slam::viewer_frames_test
