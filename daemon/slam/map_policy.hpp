// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "slam/keyframe_map.hpp"
#include "slam/loop_closer.hpp"
#include "slam/reference_selector.hpp"
#include "slam/session_tracker.hpp"

namespace slam {

/// What a robot does to the map that it is in: GrowingMap or FixedMap.
class MapPolicy {
 public:
  MapPolicy(const BackEndConfig& config, KeyframeMap& map, ReferenceSelector& reference)
      : config_(config), map_(map), reference_(reference) {}
  virtual ~MapPolicy() = default;

  /// Takes the first keyframe of a session, whose place in the map is not known.
  virtual void begin(const Keyframe& first, SessionTracker& session) = 0;
  /// Whether the map holds what is seen from a place [m], as far as it can.
  virtual bool isMapped(const Eigen::Vector2d& p_map) const = 0;
  /// Whether the session, which is not found in the map, shall be the map.
  virtual bool outgrownBy(const SessionTracker& session) const = 0;
  /// The session was found, and its keyframes lie where they are in the map. A correction becomes due.
  virtual void place(const Relocalisation::Found& found, const SessionTracker& session) = 0;
  /// The newest keyframe is a placed session's.
  virtual void extend(const Keyframe& keyframe) = 0;
  /// The reference goes where the robot goes, with a keyframe or refresh of a placed session.
  virtual void follow(const Keyframe& keyframe) = 0;
  /// Whether scans and depth images change the grid.
  virtual bool draws() const = 0;
  virtual void addTo(BackEndCounters&) const {}

 protected:
  BackEndConfig config_;
  KeyframeMap& map_;
  ReferenceSelector& reference_;
};

/// The robot makes the map: keyframes are joined to it, and loops closed. A session that was found in it is only tied
/// to it until the robot has driven a few metres without getting lost; getting lost undoes that completely. A map of a
/// few keyframes (a bad first scan, a robot that was switched on while it was carried) is left to a session that was
/// not found in it and outgrows it.
class GrowingMap : public MapPolicy {
 public:
  using MapPolicy::MapPolicy;
  void begin(const Keyframe& first, SessionTracker& session) override;
  bool isMapped(const Eigen::Vector2d& p_map) const override;
  bool outgrownBy(const SessionTracker& session) const override;
  void place(const Relocalisation::Found& found, const SessionTracker& session) override;
  void extend(const Keyframe& keyframe) override;
  void follow(const Keyframe& keyframe) override;
  bool draws() const override { return !map_.join; }
  void addTo(BackEndCounters& counters) const override {
    loops_.addTo(counters);
    counters.taken_back = taken_back_;
  }

 private:
  void addMotionEdge(const Keyframe& keyframe);

  LoopCloser loops_{config_};
  int taken_back_ = 0;
};

/// The map is given: no session becomes part of it, and the reference is what lies around the robot.
class FixedMap : public MapPolicy {
 public:
  using MapPolicy::MapPolicy;
  void begin(const Keyframe& first, SessionTracker& session) override;
  bool isMapped(const Eigen::Vector2d&) const override { return true; }
  bool outgrownBy(const SessionTracker&) const override { return false; }
  void place(const Relocalisation::Found& found, const SessionTracker& session) override;
  void extend(const Keyframe&) override {}
  void follow(const Keyframe& keyframe) override;
  bool draws() const override { return false; }

 private:
  void renew(const Eigen::Vector2d& robot, std::int32_t session);

  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();  // [m] of the reference, in map
};

/// As the configuration says.
std::unique_ptr<MapPolicy> mapPolicy(const BackEndConfig& config, KeyframeMap& map, ReferenceSelector& reference);

}  // namespace slam
