// SPDX-License-Identifier: BSD-3-Clause
#include "slam/back_end.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "posegraph/gauge.hpp"

namespace slam {
namespace {

constexpr double kTake = 2.0, kLeave = 3.0;  // times active_sigma: of keyframes taken into and out of the reference
constexpr double kNoInformation = 1e-6;      // [1/m^2, 1/rad^2]
constexpr double kSeenFrom = 5.0;            // [m] a map knows what lies this near to its keyframes
const Eigen::Vector3d kGivenSigma(0.2, 0.2, 0.1);  // [m, m, rad]
constexpr SearchWindow kGivenWindow{1.0, 0.6};     // around a pose that a person gave

}  // namespace

BackEnd::BackEnd(const BackEndConfig& config)
    : config_(config),
      search_(config.closure, config.relocalisation.places, config.reference, config.match),
      optimiser_(config.optimiser) {}

void BackEnd::load(KeyframeGraph map, std::vector<char> in_map) {
  keyframes_ = std::move(map);
  given_size_ = segment_first_ = keyframes_.size();
  const auto size = static_cast<std::size_t>(given_size_);
  in_reference_.resize(size);
  is_in_reference_.assign(size, 0);
  is_in_map_ = std::move(in_map);
  placed_ = given_size_ == 0;
}

void BackEnd::add(const Keyframe& keyframe, bool may_correct) {
  just_placed_ = -1;
  if (!keyframe.look) {
    ++counters_.keyframes;
    if (keyframe.origin != KeyframeOrigin::kContinued) {
      beginSegment(keyframe);
    } else {
      keyframes_.add(keyframe);
      in_reference_.push_back(keyframes_.pose(keyframe.id));  // the front end has put it there itself
      is_in_reference_.push_back(1);
      is_in_map_.push_back(placed_);
    }
    if (!placed_ && may_correct) findSegment();
    if (!placed_ || just_placed_ >= 0) return;
    if (!config_.localise_only) {  // else a keyframe of before the robot was found, and the given map stays as it is
      if (keyframe.observable > 0) linkToReference(keyframe);
      if (config_.close_loops) closeLoops();
    }
  }
  if (!may_correct || !placed_ || keyframe.segment != segment_ || keyframes_.size() == 0) return;
  if (config_.localise_only) {
    followInGivenMap((keyframe.look ? keyframe.T_map_base : keyframes_.pose(keyframe.id)).translation());
  } else if (config_.close_loops) {
    renewReferenceIfStale(keyframe.look ? keyframe.id : keyframes_.size() - 1);
  }
}

void BackEnd::beginSegment(const Keyframe& keyframe) {
  if (config_.localise_only) {  // the segment before was not part of the map
    const auto size = static_cast<std::size_t>(given_size_);
    keyframes_.truncate(given_size_);
    in_reference_.resize(size);
    is_in_reference_.resize(size);
    is_in_map_.resize(size);
  }
  segment_first_ = keyframe.id;
  segment_ = keyframe.segment;
  segment_origin_ = keyframe.origin;
  placed_ = false;
  std::fill(is_in_reference_.begin(), is_in_reference_.end(), 0);
  keyframes_.add(std::make_shared<const StoredScan>(keyframe), keyframe.T_map_base);
  in_reference_.push_back(keyframe.T_map_base);
  is_in_reference_.push_back(1);
  is_in_map_.push_back(0);
  if (keyframe.id > 0 && !config_.localise_only) {
    // An edge that knows nothing keeps the graph in one piece.
    keyframes_.graph().addEdge({.from = keyframe.id - 1,
                                .to = keyframe.id,
                                .T_from_to = between(keyframes_.pose(keyframe.id - 1), keyframe.T_map_base),
                                .information = kNoInformation * Eigen::Matrix3d::Identity(),
                                .kind = EdgeKind::kMotion});
  }
  // In a given map the search's pyramid stays good.
  const bool known = relocalisation_ && config_.localise_only;
  if (!relocalisation_) relocalisation_.emplace(config_.relocalisation, config_.reference, config_.match);
  known ? relocalisation_->begin() : relocalisation_->begin(keyframes_, mapIds());
}

std::vector<int> BackEnd::mapIds() const {
  std::vector<int> ids;
  for (int id = 0; id < keyframes_.size(); ++id) {
    if (inMap(id)) ids.push_back(id);
  }
  return ids;
}

void BackEnd::findSegment() {
  const int newest = keyframes_.size() - 1;
  if (segment_origin_ == KeyframeOrigin::kGiven) {
    if (const auto found = relocalisation_->searchNear(keyframes_, segment_first_, newest, kGivenWindow)) {
      placeSegment(*found);
    } else if (newest - segment_first_ + 1 >= config_.given_attempts) {
      giveUpGivenPose(newest);
    }
  } else if (const auto found = relocalisation_->search(keyframes_, segment_first_, newest)) {
    placeSegment(*found);
  }
  counters_.placed += placed_ ? 1 : 0;
  counters_.relocalisation = relocalisation_->counters();
  if (!placed_ && outgrown()) beginAnew();
}

bool BackEnd::outgrown() const {
  if (config_.localise_only || given_size_ > 0) return false;
  const auto known = static_cast<int>(std::count(is_in_map_.begin(), is_in_map_.end(), 1));
  return known <= config_.few_keyframes && keyframes_.size() - segment_first_ > config_.outgrown * known;
}

/// Forgets the map: the segment, where it is, becomes the map.
void BackEnd::beginAnew() {
  std::fill(is_in_map_.begin(), is_in_map_.end(), 0);
  first_in_map_ = segment_first_;
  ++counters_.begun_anew;
  placeSegment({keyframes_.pose(keyframes_.size() - 1), {}});
}

void BackEnd::giveUpGivenPose(int newest) {
  const auto near = keyframes_.near(keyframes_.pose(newest).translation(), kSeenFrom);
  const bool known = std::any_of(near.begin(), near.end(), [&](int id) { return inMap(id); });
  if (known || config_.localise_only) {  // it does not look as it should: the robot may be anywhere
    segment_origin_ = KeyframeOrigin::kLost;
    due_ = spare_ ? std::move(spare_) : std::make_unique<MapCorrection>(config_.reference);
    due_->T_map_segment.reset();
    due_->refuted = true;
    due_->segment = segment_;
  } else {  // the map says nothing about the place: the person's word counts
    Relocalisation::Found given{keyframes_.pose(newest), {}};
    given.match.covariance = kGivenSigma.cwiseAbs2().asDiagonal();
    given.match.directions.setIdentity();
    given.match.T_ref_base = keyframes_.pose(newest);
    given.match.observable = 3;
    placeSegment(given);
  }
}

void BackEnd::placeSegment(const Relocalisation::Found& found) {
  const int newest = keyframes_.size() - 1;
  const Pose2 T_map_segment = found.T_map_newest * keyframes_.pose(newest).inverse();
  for (int id = segment_first_; id <= newest; ++id) {
    keyframes_.graph().setPose(id, T_map_segment * keyframes_.pose(id));
  }
  placed_ = true;
  if (config_.localise_only) {
    followInGivenMap(found.T_map_newest.translation());
    if (due_) due_->T_map_segment = T_map_segment;
    return;
  }
  // Joined at the map's keyframe nearest to the newest one.
  int nearest = -1;
  double shortest = std::numeric_limits<double>::infinity();
  for (int id = 0; id < segment_first_; ++id) {
    const double apart = (keyframes_.pose(id).translation() - found.T_map_newest.translation()).norm();
    if (!inMap(id) || apart >= shortest) continue;
    shortest = apart;
    nearest = id;
  }
  if (nearest >= 0) {  // else the map begins with this segment
    keyframes_.graph().addEdge({.from = nearest,
                                .to = newest,
                                .T_from_to = between(keyframes_.pose(nearest), found.T_map_newest),
                                .information = closureInformation(found.match, config_.closure.translation_sigma,
                                                                  config_.closure.rotation_sigma),
                                .kind = EdgeKind::kLoopClosure});
  }
  std::fill(is_in_map_.begin() + segment_first_, is_in_map_.end(), 1);
  just_placed_ = segment_first_;
  ++generation_;
  renewReference(keyframes_.pose(newest).translation(), knownFrom(newest));
  due_->T_map_segment = T_map_segment;
}

/// The keyframes around `anchor` whose place relative to it is known well enough to be matched against.
std::vector<int> BackEnd::knownFrom(int anchor) const {
  const Eigen::Vector2d robot = keyframes_.pose(anchor).translation();
  std::vector<int> known;
  for (const auto& reached : keyframes_.graph().reach(anchor, std::pow(kTake * config_.closure.active_sigma, 2))) {
    if ((keyframes_.pose(reached.node).translation() - robot).norm() <= config_.reference_radius) {
      known.push_back(reached.node);
    }
  }
  std::sort(known.begin(), known.end());
  return known;
}

void BackEnd::followInGivenMap(const Eigen::Vector2d& robot) {
  const bool has_reference = segment_of_reference_ == segment_;
  if (has_reference && (robot - reference_centre_).norm() < config_.renewal_travel) return;
  auto ids = keyframes_.near(robot, config_.reference_radius);
  std::erase_if(ids, [&](int id) { return id >= given_size_; });
  renewReference(robot, ids);
  reference_centre_ = robot;
  segment_of_reference_ = segment_;
}

/// Ties a keyframe to an older one that it was matched against, in the directions that the match saw.
void BackEnd::linkToReference(const Keyframe& keyframe) {
  const int newest = keyframes_.size() - 1;
  int nearest = -1;
  double shortest = config_.link_distance;
  for (int id = 0; id <= newest - config_.link_age; ++id) {
    if (!is_in_reference_[static_cast<std::size_t>(id)]) continue;
    const Pose2 &a = keyframes_.pose(id), &b = keyframes_.pose(newest);
    const double distance = (a.translation() - b.translation()).norm();
    if (distance >= shortest) continue;
    const double apart = distance + 0.5 * (1.0 - std::cos(a.theta - b.theta));
    if (apart >= shortest) continue;
    shortest = apart;
    nearest = id;
  }
  if (nearest < 0) return;
  MatchResult match;
  match.T_ref_base = keyframes_.pose(newest);
  match.directions = keyframe.directions;
  match.observable = keyframe.observable;
  keyframes_.graph().addEdge(
      {.from = nearest,
       .to = newest,
       .T_from_to = between(keyframes_.pose(nearest), keyframes_.pose(newest)),
       .information = closureInformation(match, config_.link_translation_sigma, config_.link_rotation_sigma),
       .kind = EdgeKind::kMotion});
}

void BackEnd::renewReferenceIfStale(int anchor) {
  // Three thresholds, so that one keyframe after another does not renew it: what is known well must be in it, what has
  // become unknown must not, and what lies between comes along when it is renewed anyway.
  const Eigen::Vector2d robot = keyframes_.pose(anchor).translation();
  const auto variance = [&](double factor) { return std::pow(factor * config_.closure.active_sigma, 2); };
  std::vector<int> wanted;
  std::vector<char> known(is_in_reference_.size(), 0);
  bool stale = false;
  for (const auto& reached : keyframes_.graph().reach(anchor, variance(kLeave))) {
    const auto i = static_cast<std::size_t>(reached.node);
    known[i] = 1;
    const double distance = (keyframes_.pose(reached.node).translation() - robot).norm();
    if (distance > config_.reference_radius) continue;
    if (reached.position_variance < variance(kTake)) wanted.push_back(reached.node);
    stale |= !is_in_reference_[i] && reached.position_variance < variance(1.0) && distance < config_.renewal_radius;
  }
  for (std::size_t i = 0; i < is_in_reference_.size() && !stale; ++i) {
    if (!is_in_reference_[i]) continue;
    const Pose2& pose = keyframes_.pose(static_cast<int>(i));
    const Eigen::Vector2d position = pose.translation();
    stale = (position - in_reference_[i].translation()).norm() > config_.renewal_shift ||
            std::abs(wrapAngle(pose.theta - in_reference_[i].theta)) > config_.renewal_turn ||
            (!known[i] && (position - robot).norm() < config_.renewal_radius);
  }
  if (!stale) return;
  std::sort(wanted.begin(), wanted.end());
  renewReference(robot, wanted);
}

void BackEnd::renewReference(const Eigen::Vector2d& robot, const std::vector<int>& active) {
  due_ = spare_ ? std::move(spare_) : std::make_unique<MapCorrection>(config_.reference);
  due_->reference.clear(robot);
  due_->T_map_segment.reset();
  due_->refuted = false;
  due_->segment = segment_;
  keyframes_.addTo(due_->reference, active);
  due_->keyframes.clear();
  std::fill(is_in_reference_.begin(), is_in_reference_.end(), 0);
  for (const int id : active) {
    due_->keyframes.push_back({id, keyframes_.pose(id)});
    in_reference_[static_cast<std::size_t>(id)] = keyframes_.pose(id);
    is_in_reference_[static_cast<std::size_t>(id)] = 1;
  }
  due_->newest = keyframes_.size() - 1;
  ++counters_.corrections;
}

std::vector<MapScan> BackEnd::mapScans(const Keyframe& keyframe) const {
  std::vector<MapScan> scans;
  if (!placed_ || config_.localise_only || keyframe.segment != segment_) return scans;
  if (keyframe.look) {
    scans.push_back(
        {-1, keyframes_.pose(keyframe.id) * keyframe.T_previous_base, std::make_shared<const StoredScan>(keyframe)});
    return scans;
  }
  for (int id = just_placed_ < 0 ? keyframe.id : just_placed_; id <= keyframe.id; ++id) {
    scans.push_back({id, keyframes_.pose(id), keyframes_.scan(id)});
  }
  return scans;
}

std::optional<MapView> BackEnd::mapView(const DepthSight& sight) const {
  const bool known = sight.keyframe >= 0 && sight.keyframe < keyframes_.size() && inMap(sight.keyframe);
  if (!placed_ || config_.localise_only || sight.segment != segment_ || !known) return std::nullopt;
  return MapView{sight.keyframe, keyframes_.pose(sight.keyframe), sight.T_keyframe_base,
                 std::make_shared<const DepthView>(sight.laser, config_.T_base_depth)};
}

std::unique_ptr<MapCorrection> BackEnd::takeCorrection() { return std::move(due_); }

void BackEnd::closeLoops() {
  const auto closures = search_.search(keyframes_, is_in_map_);
  counters_.search = search_.counters();
  if (closures.empty()) return;
  const std::vector<Pose2> before(keyframes_.graph().poses().begin(), keyframes_.graph().poses().end());
  for (const Edge& edge : closures) keyframes_.graph().addEdge(edge);
  optimiser_.optimise(keyframes_.graph());
  ++counters_.optimisations;
  revokeContradicted();
  holdMap(before);
  counters_.loop_closures = static_cast<int>(
      std::count_if(keyframes_.graph().edges().begin(), keyframes_.graph().edges().end(),
                    [](const Edge& edge) { return edge.kind == EdgeKind::kLoopClosure && !edge.revoked; }));
  ++generation_;
}

/// Lays the optimised map where it moves least.
void BackEnd::holdMap(std::span<const Pose2> before) {
  PoseGraph& graph = keyframes_.graph();
  std::vector<Pose2> T_map_node, T_new_node;
  for (int id = 0; id < graph.size(); ++id) {
    if (!inMap(id)) continue;
    T_map_node.push_back(before[static_cast<std::size_t>(id)]);
    T_new_node.push_back(graph.pose(id));
  }
  const Pose2 T_map_new = holdGauge(T_map_node, T_new_node);
  for (int id = 0; id < graph.size(); ++id) graph.setPose(id, T_map_new * graph.pose(id));
}

void BackEnd::revokeContradicted() {
  // One at a time, the worst first: taking it back may satisfy the others.
  for (;;) {
    PoseGraph& graph = keyframes_.graph();
    int worst = -1;
    double largest = config_.closure.max_chi_square;
    for (std::size_t e = 0; e < graph.edges().size(); ++e) {
      const Edge& edge = graph.edges()[e];
      if (edge.kind != EdgeKind::kLoopClosure || edge.revoked) continue;
      const double chi_square = chiSquare(edge, graph.pose(edge.from), graph.pose(edge.to));
      if (chi_square <= largest) continue;
      largest = chi_square;
      worst = static_cast<int>(e);
    }
    if (worst < 0) return;
    graph.revoke(worst);
    ++counters_.revoked;
    optimiser_.optimise(graph);
    ++counters_.optimisations;
  }
}

}  // namespace slam
