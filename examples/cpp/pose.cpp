// SPDX-License-Identifier: BSD-3-Clause
// Prints where the robot is, ten times a second. With the package slamd-dev:
//   g++ -std=c++17 pose.cpp -o pose $(pkg-config --cflags --libs slamd)
#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <slam/pose_estimate_t.hpp>

namespace {

constexpr long kPeriod = 100'000;  // [us] between printed poses
const char* const kStates[] = {"initialising", "localised", "degraded", "lost"};

struct Printer {
  void print(const lcm::ReceiveBuffer*, const std::string&, const slam::pose_estimate_t* pose) {
    if (pose->utime - printed < kPeriod && pose->utime >= printed) return;
    printed = pose->utime;
    std::printf("%s: x %.3f m, y %.3f m, theta %.3f rad\n", kStates[pose->state & 3], pose->x, pose->y, pose->theta);
    std::fflush(stdout);
  }
  long printed = 0;  // [us since the epoch]
};

}  // namespace

int main() {
  lcm::LCM lcm;  // of this computer, or what LCM_DEFAULT_URL says
  if (!lcm.good()) {
    std::fprintf(stderr, "no LCM: is there a route for multicast? slamctl doctor\n");
    return 1;
  }
  Printer printer;
  lcm.subscribe("SLAM_POSE", &Printer::print, &printer);
  while (lcm.handle() == 0) {
  }
}
