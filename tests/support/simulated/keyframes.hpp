// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/keyframe.hpp"
#include "graph/keyframe_graph.hpp"
#include "matching/places.hpp"
#include "matching/scan_points.hpp"

namespace slam::test {

/// Keyframes of a drive, as the front end hands them over, with steps as wrong as the test wants them.
class KeyframeDrive {
 public:
  explicit KeyframeDrive(Place scene, unsigned seed = 1) : place(std::move(scene)), random(seed) {}

  /// A keyframe at a true pose. @param error of the measured step, @param sigma [m, m, rad] what the front end claims
  const Keyframe& at(const Pose2& T_world_base, const Pose2& error, const Eigen::Vector3d& sigma) {
    describe(T_world_base);
    keyframe_->id = static_cast<std::int32_t>(truth.size());
    keyframe_->refresh = false;
    keyframe_->T_previous_base = truth.empty() ? Pose2{} : between(truth.back(), T_world_base) * error;
    keyframe_->T_map_base = truth.empty() ? Pose2{} : measured.back() * keyframe_->T_previous_base;
    keyframe_->step_covariance = sigma.cwiseAbs2().asDiagonal();
    truth.push_back(T_world_base);
    measured.push_back(keyframe_->T_map_base);
    return *keyframe_;
  }
  /// A keyframe whose step errs at random, as the front end claims.
  const Keyframe& at(const Pose2& T_world_base, const Eigen::Vector3d& sigma) {
    std::normal_distribution<double> normal;
    const Eigen::Vector3d e = sigma.cwiseProduct(Eigen::Vector3d(normal(random), normal(random), normal(random)));
    return at(T_world_base, Pose2::fromVector(e), sigma);
  }
  /// A refresh from a true pose, anchored to a keyframe.
  const Keyframe& refresh(const Pose2& T_world_base, int anchor) {
    describe(T_world_base);
    const auto i = static_cast<std::size_t>(anchor);
    keyframe_->id = anchor;
    keyframe_->refresh = true;
    keyframe_->T_previous_base = between(truth[i], T_world_base);
    keyframe_->T_map_base = measured[i] * keyframe_->T_previous_base;
    return *keyframe_;
  }

  Pose2 trueRelative(int a, int b) const {
    return between(truth[static_cast<std::size_t>(a)], truth[static_cast<std::size_t>(b)]);
  }

  Place place;
  std::mt19937 random;
  std::vector<Pose2> truth, measured;  ///< by id

 private:
  void describe(const Pose2& T_world_base) {
    keyframe_->stamp += std::chrono::seconds(1);
    keyframe_->size = 0;
    for (const ScanPoint& point : place.scan(T_world_base, 0.01, random)) {
      keyframe_->storage[static_cast<std::size_t>(keyframe_->size++)] = keyframePoint(point);
    }
  }
  std::unique_ptr<Keyframe> keyframe_ = std::make_unique<Keyframe>();
};

/// A map of keyframes, and a robot that drives in it, or elsewhere, without knowing where it began.
class MappedPlace {
 public:
  MappedPlace(const Place& mapped, const std::vector<Pose2>& poses, unsigned seed, const Place& now,
              unsigned drive_seed)
      : drive_(now, drive_seed) {
    KeyframeDrive map_drive(mapped, seed);
    for (const Pose2& pose : poses) {
      map.push_back(keyframes.size());
      add(map_drive.at(pose, Pose2{}, kStep), pose);
    }
  }
  /// The robot's next keyframe is there.
  void drive(const Pose2& truth) {
    const Keyframe& keyframe = drive_.at(truth, kStep);
    add(keyframe, keyframe.T_map_base);
  }
  int newest() const { return keyframes.size() - 1; }

  KeyframeGraph keyframes;
  std::vector<int> map;  ///< ids of its keyframes

 private:
  void add(const Keyframe& keyframe, const Pose2& T_map_base) {
    keyframes.add(std::make_shared<const StoredScan>(keyframe), T_map_base);
  }
  inline static const Eigen::Vector3d kStep{0.002, 0.002, 0.0005};  // [m, m, rad]
  KeyframeDrive drive_;
};

/// Poses along the x axis, one in so many metres.
inline std::vector<Pose2> alongX(double from, double to, double step = 0.5) {
  std::vector<Pose2> poses;
  for (double x = from; x <= to; x += step) poses.push_back({x, 0.0, 0.0});
  return poses;
}

/// A corridor 2 m wide around a block of 10 m by 6 m, with cupboards at irregular places.
inline Place ringCorridor() {
  Place place{.name = "Ring", .low = {-6.5, -4.5}, .high = {6.5, 4.5}, .reach = 10.0};
  addWalls(place.world, {{-7, -5}, {7, -5}, {7, 5}, {-7, 5}});
  addWalls(place.world, {{-5, -3}, {5, -3}, {5, 3}, {-5, 3}});
  for (const double x : {-5.6, -2.1, 0.4, 3.7}) place.world.add(sim::Box{x, -4.8, 0.0, 0.9, 0.4});
  for (const double x : {-4.0, -0.7, 4.3}) place.world.add(sim::Box{x, 4.85, 0.0, 1.2, 0.3});
  for (const double y : {-2.2, 1.6}) place.world.add(sim::Box{6.8, y, 0.0, 0.4, 0.7});
  for (const double y : {-3.1, -0.4, 2.9}) place.world.add(sim::Box{-6.85, y, 0.0, 0.3, 1.0});
  place.world.add(sim::Cylinder{1.5, 3.2, 0.2});
  place.world.add(sim::Cylinder{-2.5, -3.2, 0.25});
  return place;
}

/// Pose on the middle of that corridor, counter-clockwise. @param distance [m] from its south-western corner
inline Pose2 onRing(double distance) {
  constexpr double kLength = 12.0, kWidth = 8.0;
  double rest = std::fmod(distance, 2 * (kLength + kWidth));
  Pose2 corner{-kLength / 2, -kWidth / 2, 0.0};
  for (const double side : {kLength, kWidth, kLength, kWidth}) {
    if (rest < side) break;
    rest -= side;
    corner = corner * Pose2{side, 0.0, std::numbers::pi / 2};
  }
  return corner * Pose2{rest, 0.0, 0.0};
}

/// Two rooms that are alike in everything.
constexpr double kTwins = 20.0;  // [m] from the middle of one to that of the other
inline Place twins() {
  Place place{.name = "Twins", .low = {-2, -2}, .high = {2, 2}};
  for (const double x : {0.0, kTwins}) {
    addWalls(place.world, {{x - 3, -2}, {x + 3, -2}, {x + 3, 2}, {x - 3, 2}});
    place.world.add(sim::Box{x - 2.5, 1.2, 0.0, 0.8, 1.4});
    place.world.add(sim::Cylinder{x + 1.0, -0.9, 0.2});
  }
  return place;
}

inline std::vector<Pose2> inTwins() {
  std::vector<Pose2> poses = alongX(-1.0, 2.0);
  for (const Pose2& pose : alongX(kTwins - 1.0, kTwins + 2.0)) poses.push_back(pose);
  return poses;
}

/// A corridor 2.3 m wide, 140 m long, with door niches 15 cm deep at irregular places.
inline Place corridorWithIrregularDoors(unsigned seed) {
  Place place{.name = "IrregularDoors", .low = {-1.0, -0.6}, .high = {110.0, 0.6}, .reach = 8.0};
  addWalls(place.world, {{-20, -1.3}, {120, -1.3}, {120, 1.3}, {-20, 1.3}});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> wall(1.0, 4.5);
  for (const double y : {-1.225, 1.225}) {
    for (double x = -19.0; x < 119.0;) {
      const double length = wall(random);
      place.world.add(sim::Box{x + 0.5 * length, y, 0.0, length, 0.15});
      x += length + 0.95;
    }
  }
  return place;
}

}  // namespace slam::test
