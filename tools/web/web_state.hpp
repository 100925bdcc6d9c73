// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <slam/depth_t.hpp>
#include <slam/health_t.hpp>
#include <slam/map_edit_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problems_t.hpp>
#include <slam/scan_t.hpp>
#include <vector>

#include "config/config.hpp"
#include "core/pose_history.hpp"
#include "core/timestamp.hpp"
#include "tools/web/history/day_history.hpp"
#include "tools/web/maps/edit_board.hpp"
#include "tools/web/tile_store.hpp"

namespace slam {

/// Where the robot drove in map.
class DrivenPath {
 public:
  static constexpr std::size_t kLongestTrail = 4000;  ///< [points] 200 m; then its older half gets coarser

  /// Begins the poses anew where they do not follow those before: another slamd, or a clock that was set.
  void add(Timestamp stamp, const Pose2& T_map_base);
  void extendTrail(const Eigen::Vector2d& at);
  void clear();
  const PoseHistory& poses() const { return poses_; }
  const std::deque<Eigen::Vector2d>& trail() const { return trail_; }  ///< [m] in map, oldest first

 private:
  PoseHistory poses_{300};  // of base in map, 3 s
  std::deque<Eigen::Vector2d> trail_;
};

/// What the page shows, from slamd's messages. Pure: time is given. Its memory is bounded whatever comes.
class WebState {
 public:
  static constexpr std::size_t kMostClosures = 100;
  static constexpr std::size_t kMostPoints = 720;  ///< of a scan or depth view

  using Points = std::vector<Eigen::Vector2d>;
  /// Where the map was corrected.
  struct Closure {
    Eigen::Vector2d at;  ///< [m] of the robot, in map
    std::int64_t total;  ///< closures so far
  };
  /// Grows with each message of a kind, so that "is there a newer one" is a comparison.
  struct Serials {
    std::uint64_t pose = 0, health = 0, scan = 0, depth = 0, closure = 0, map = 0;
  };

  explicit WebState(const Config& config);

  void take(const pose_estimate_t& pose, Timestamp now);
  void take(const health_t& health, Timestamp now);
  void take(const problems_t& problems, Timestamp now);
  void take(const scan_t& scan, Timestamp now);
  void take(const depth_t& depth, Timestamp now);
  void take(const map_meta_t& meta, Timestamp now);
  void take(MapLayer layer, const map_tile_t& tile, Timestamp now);
  void take(const map_edit_t& edit, Timestamp now);

  const Serials& serials() const { return serials_; }
  const std::optional<pose_estimate_t>& pose() const { return pose_.newest; }
  std::int64_t sinceState() const { return pose_.since; }  ///< [us since the epoch] the pose has its state; 0: unknown
  const std::optional<health_t>& health() const { return health_; }
  const problems_t& problems() const { return problems_; }  ///< that came before it
  const std::optional<map_meta_t>& meta() const { return meta_; }
  const Points& scan() const { return seen_.scan; }  ///< [m] returns of the newest scan in map, of each beam's own time
  const Points& depth() const { return seen_.depth; }  ///< [m] obstacles of the newest depth view in map
  const std::deque<Eigen::Vector2d>& trail() const { return path_.trail(); }  ///< [m] in map, oldest first
  const std::deque<Closure>& closures() const { return closures_.all; }
  const TileStore& tiles() const { return tiles_; }
  const EditBoard& edits() const { return edits_; }
  const DayHistory& day() const { return day_; }
  /// What was kept before slam-web ended.
  void begin(DayHistory day) { day_ = std::move(day); }
  /// A person marks the log now.
  void mark(const std::string& words) { day_.mark(words); }
  std::uint64_t badMessages() const { return bad_messages_; }
  void countBadMessage() { ++bad_messages_; }
  /// Since slamd was heard last; since the start where it never was.
  Duration silence(Timestamp now) const { return now - last_received_; }
  void begin(Timestamp now) { last_received_ = now; }

 private:
  void beginMap(std::int32_t map_id);
  void add(Points& points, const Eigen::Vector2d& p_map);

  LidarModel lidar_;
  struct {
    Pose2 T_base_camera;
    double time_offset;  // [s]
  } depth_mount_;
  Serials serials_;
  Timestamp last_received_{};
  struct {
    std::optional<pose_estimate_t> newest;
    std::int64_t since = 0;  // [us since the epoch] when its state changed last
  } pose_;
  std::optional<health_t> health_;
  problems_t problems_{};
  std::optional<map_meta_t> meta_;
  DrivenPath path_;
  struct {
    Points scan, depth;
  } seen_;
  struct {
    std::deque<Closure> all;
    std::optional<std::int64_t> counted;
  } closures_;
  TileStore tiles_;
  EditBoard edits_;
  DayHistory day_;
  std::uint64_t bad_messages_ = 0;
};

}  // namespace slam
