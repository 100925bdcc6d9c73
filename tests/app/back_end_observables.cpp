// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <random>
#include <sstream>

#include "app/observables.hpp"
#include "estimation/wheel_monitor.hpp"
#include "slam/map_builder.hpp"
#include "support/simulated/keyframes.hpp"

namespace slam::test {
namespace {

const Eigen::Vector3d kDrift(0.01, 0.01, 0.002);  // [m, m, rad] a step

/// A map whose corrections take effect at once.
class Map {
 public:
  explicit Map(const Config& config) : builder_(backEndConfig(config)) {}
  void add(const Keyframe& keyframe) {
    if (auto correction = builder_.add(keyframe).correction) builder_.recycle(std::move(correction));
  }
  const auto& backEnd() const { return builder_.backEnd(); }

 private:
  MapBuilder builder_;
};

std::string words(const Map& map) {
  std::ostringstream text;
  const auto& back_end = map.backEnd();
  const BackEndCounters& c = back_end.counters();
  text << c.loop_closures << ' ' << c.revoked << ' ' << c.placed << ' ' << c.search.accepted << ' '
       << c.search.inconsistent << ' ' << c.relocalisation.found << ' ' << c.relocalisation.refused << '\n';
  for (const Pose2& pose : back_end.keyframes().graph().poses()) text << pose.vector().transpose() << '\n';
  return text.str();
}

}  // namespace

std::string backEnd(const Config& config) {
  Map map(config);
  KeyframeDrive drive(ringCorridor());
  for (double s = 1.0; s < 50.0; s += 0.5) map.add(drive.at(onRing(s), kDrift));
  return words(map);
}

std::string movedRoom(const Config& config) {
  Map map(config);
  KeyframeDrive drive(furnishedRoom());
  const Pose2 start{-1.9, -0.9, 0.0}, door{-1.2, 0.7, 0.2}, shift{0.0, 0.4, 0.0};
  const auto visit = [&](const Pose2& moved) {
    for (int i = 0; i < 15; ++i)
      map.add(drive.at(moved * start * Pose2{0.25 * i, 0.0, 0.0}, {}, {0.004, 0.004, 0.001}));
  };
  visit({});
  const Pose2 honest = between(drive.truth.back(), door), seen = between(drive.truth.back(), shift * door);
  map.add(drive.at(shift * door, seen.inverse() * honest, {0.25, 0.01, 0.001}));
  visit(shift);
  return words(map);
}

std::string lostBackEnd(const Config& config) {
  Map map(config);
  KeyframeDrive drive(ringCorridor());
  for (double s = 0.0; s < 40.0; s += 0.5) map.add(drive.at(onRing(s), {}, 0.2 * kDrift));
  const auto lost = std::make_unique<Keyframe>();
  std::string text;
  for (int step = 0; step < 10; ++step) {
    *lost = drive.at(onRing(13.2 + 0.5 * step), {}, 0.2 * kDrift);
    lost->session = 1;
    if (step == 0) lost->origin = KeyframeOrigin::kLost;
    map.add(*lost);
    text += std::to_string(map.backEnd().counters().placed);
  }
  return text + words(map);
}

std::string wheelTrust(const Config& config) {
  const FrontEndConfig front_end = frontEndConfig(config);
  WheelMonitor monitor(front_end.ekf, front_end.wheel_monitor);
  monitor.add({});
  std::string text;
  Pose2 wheels, scans;
  for (int i = 0; i < 200; ++i) {
    const double slip = i < 20 ? 0.2 : 0.005;  // [m]
    wheels = wheels * Pose2{0.06 + slip, 0.0, 0.0};
    scans = scans * Pose2{0.06, 0.0, 0.0};
    monitor.compare(wheels, scans, false);
    text += "--bgg"[static_cast<int>(monitor.reliability())];
  }
  return text;
}

}  // namespace slam::test
