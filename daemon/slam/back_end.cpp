// SPDX-License-Identifier: BSD-3-Clause
#include "slam/back_end.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kTake = 2.0, kLeave = 3.0;  // times active_sigma: of keyframes taken into and out of the reference

}  // namespace

BackEnd::BackEnd(const BackEndConfig& config)
    : config_(config), search_(config.closure, config.reference, config.match), optimiser_(config.optimiser) {}

void BackEnd::add(const Keyframe& keyframe, bool may_correct) {
  if (!keyframe.look) {
    keyframes_.add(keyframe);
    ++counters_.keyframes;
    in_reference_.push_back(keyframes_.pose(keyframe.id));  // the front end has put it there itself
    is_in_reference_.push_back(1);
    linkToReference();
    if (config_.close_loops) closeLoops();
  }
  if (!config_.close_loops || !may_correct || keyframes_.size() == 0) return;
  const int anchor = keyframe.look ? keyframe.id : keyframes_.size() - 1;
  renewReferenceIfStale(anchor);
}

void BackEnd::linkToReference() {
  const int newest = keyframes_.size() - 1;
  int nearest = -1;
  double shortest = config_.link_distance;
  for (int id = 0; id <= newest - config_.link_age; ++id) {
    if (!is_in_reference_[static_cast<std::size_t>(id)]) continue;
    const Pose2 relative = between(keyframes_.pose(id), keyframes_.pose(newest));
    const double apart = std::hypot(relative.x, relative.y) + 0.5 * (1.0 - std::cos(relative.theta));
    if (apart >= shortest) continue;
    shortest = apart;
    nearest = id;
  }
  if (nearest < 0) return;
  const Eigen::Vector3d sigma(config_.link_translation_sigma, config_.link_translation_sigma,
                              config_.link_rotation_sigma);
  keyframes_.graph().addEdge({.from = nearest,
                              .to = newest,
                              .T_from_to = between(keyframes_.pose(nearest), keyframes_.pose(newest)),
                              .information = sigma.cwiseAbs2().cwiseInverse().asDiagonal(),
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
    const Eigen::Vector2d position = keyframes_.pose(static_cast<int>(i)).translation();
    stale = (position - in_reference_[i].translation()).norm() > config_.renewal_shift ||
            (!known[i] && (position - robot).norm() < config_.renewal_radius);
  }
  if (!stale) return;
  std::sort(wanted.begin(), wanted.end());
  renewReference(anchor, wanted);
}

void BackEnd::renewReference(int anchor, const std::vector<int>& active) {
  due_ = spare_ ? std::move(spare_) : std::make_unique<MapCorrection>(config_.reference);
  due_->reference.clear(keyframes_.pose(anchor).translation());
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

MapScan BackEnd::mapScan(const Keyframe& keyframe) const {
  if (!keyframe.look) return {keyframe.id, keyframes_.pose(keyframe.id), keyframes_.scan(keyframe.id)};
  return {-1, keyframes_.pose(keyframe.id) * keyframe.T_previous_base, std::make_shared<const StoredScan>(keyframe)};
}

std::unique_ptr<MapCorrection> BackEnd::takeCorrection() { return std::move(due_); }

void BackEnd::closeLoops() {
  const auto closures = search_.search(keyframes_);
  counters_.search = search_.counters();
  if (closures.empty()) return;
  for (const Edge& edge : closures) keyframes_.graph().addEdge(edge);
  optimiser_.optimise(keyframes_.graph());
  ++counters_.optimisations;
  revokeContradicted();
  counters_.loop_closures = static_cast<int>(
      std::count_if(keyframes_.graph().edges().begin(), keyframes_.graph().edges().end(),
                    [](const Edge& edge) { return edge.kind == EdgeKind::kLoopClosure && !edge.revoked; }));
  ++generation_;
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
