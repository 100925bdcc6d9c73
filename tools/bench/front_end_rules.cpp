// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/front_end_rules.hpp"

#include <array>
#include <limits>

namespace slam {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr int kOften = std::numeric_limits<int>::max() / 2;
constexpr double kLongSilence = 1e6;  // [s]

const std::array kRules = std::to_array<Rule>({
    {"1 stamp far ahead waits", [](FrontEndConfig& c) { c.intake.stamps.far_ahead = kNever; }},
    {"1a stamps ahead of other streams", [](FrontEndConfig& c) { c.intake.stamps.ahead_of_others = kNever; }},
    {"2 stamps grow by a quarter interval", [](FrontEndConfig& c) { c.intake.stamps.least_step = 0.0; }},
    {"2, 3 clock set back", [](FrontEndConfig& c) { c.intake.stamps.set_back = kNever; }},
    {"3a lidar's delay", [](FrontEndConfig& c) { c.lidar_delay.least_error = kNever; }},
    {"4 lidar stuck", [](FrontEndConfig& c) { c.intake.repeats.stuck_turns = kOften; }},
    {"5 scan is a copy", [](FrontEndConfig& c) { c.intake.fastest_turn = c.intake.soonest_scan = 0.0; }},
    {"6a what moves with the robot", [](FrontEndConfig& c) { c.preprocessor.interpreter.body.enough = kOften; }},
    {"6f one step where all around stays",
     [](FrontEndConfig& c) { c.preprocessor.interpreter.body.most_around = kNever; }},
    {"6b ranges that scatter at rest", [](FrontEndConfig& c) { c.preprocessor.interpreter.range_noise.most = kNever; }},
    {"6c codes of no return", [](FrontEndConfig& c) { c.preprocessor.interpreter.no_return.fewest = kOften; }},
    {"6d times of the beams", [](FrontEndConfig& c) { c.preprocessor.interpreter.sweep.enough = kOften; }},
    {"6e lift", [](FrontEndConfig& c) { c.preprocessor.interpreter.cabin.largest = 0.0; }},
    {"8 points to mid-sweep", [](FrontEndConfig& c) { c.preprocessor.scan_moment = 0.0; }},
    {"9 beam spacing", [](FrontEndConfig& c) { c.preprocessor.normals.fine_spacing = kNever; }},
    {"10 grazing points slide", [](FrontEndConfig& c) { c.preprocessor.normals.in_a_row = 0.0; }},
    {"10a points seen through", [](FrontEndConfig& c) { c.preprocessor.dynamic_points.most = 0.0; }},
    {"10b the bearings' error", [](FrontEndConfig& c) { c.preprocessor.normals.bearing_sigma = 0.0; }},
    {"10c grazing points met often", [](FrontEndConfig& c) { c.match.grazing_observations = kNever; }},
    {"11 wheels judged", [](FrontEndConfig& c) { c.wheel_monitor.memory = kNever; }},
    {"11a wheels withdrawn", [](FrontEndConfig& c) { c.wheel_monitor.contradiction = kNever; }},
    {"11c wheels consistent", [](FrontEndConfig& c) { c.wheel_monitor.consistency = kNever; }},
    {"12 wheels' scale", [](FrontEndConfig& c) { c.wheel_monitor.scale.significance = kNever; }},
    {"13 slip", [](FrontEndConfig& c) { c.ekf.slip_angle = kNever; }},
    {"14 standstill",
     [](FrontEndConfig& c) { c.ekf.standstill.min_time = c.ekf.standstill.min_time_unbiased = kNever; }},
    {"14a sooner without bias",
     [](FrontEndConfig& c) { c.ekf.standstill.min_time_unbiased = c.ekf.standstill.min_time; }},
    {"14b never with silent wheels",
     [](FrontEndConfig& c) { c.ekf.short_silence = c.ekf.long_silence = kLongSilence; }},
    {"14c wheels that died", [](FrontEndConfig& c) { c.ekf.hardest_braking = kNever; }},
    {"15 sudden speeds believed", [](FrontEndConfig& c) { c.ekf.accepts_sudden_speeds = false; }},
    {"16a short intervals joined", [](FrontEndConfig& c) { c.timeline.too_soon = 0.0; }},
    {"16b mean of 0.1 s holds", [](FrontEndConfig& c) { c.timeline.recent = 0.0; }},
    {"17 doubt", [](FrontEndConfig& c) { c.ekf.max_contradiction = 1.0; }},
    {"18 other starting poses", [](FrontEndConfig& c) { c.registration.starts = 1; }},
    {"18a none after a loss of overlap", [](FrontEndConfig& c) { c.registration.sudden_loss = kNever; }},
    {"18c the wheels' turn", [](FrontEndConfig& c) { c.registration.starts = 3; }},
    {"19a gate narrows", [](FrontEndConfig& c) { c.match.initial_pair_distance = c.match.final_pair_distance; }},
    {"19b oscillation damped", [](FrontEndConfig& c) { c.match.damping = 1.0; }},
    {"20a least share of information", [](FrontEndConfig& c) { c.match.min_information = 0.0; }},
    {"20b confirmed share", [](FrontEndConfig& c) { c.match.min_confirmed = 0.0; }},
    {"20c tension between a scan's parts",
     [](FrontEndConfig& c) { c.match.part_gap = kNever, c.match.part_bend = -2.0; }},
    {"21 low overlap", [](FrontEndConfig& c) { c.match.min_overlap = 0.0; }},
    {"21a few pairs", [](FrontEndConfig& c) { c.match.min_pairs = 3; }},
    {"22 something moving pulls", [](FrontEndConfig& c) { c.dynamic_object_gate.noticeable = kNever; }},
    {"22b walls that fit at once", [](FrontEndConfig& c) { c.dynamic_object_gate.support = kNever; }},
    {"22a wheels slipped", [](FrontEndConfig& c) { c.wheel_monitor.slip = kNever; }},
    {"27b two places", [](FrontEndConfig& c) { c.search.distinct_distance = c.search.distinct_rotation = kNever; }},
    {"23 fits as before", [](FrontEndConfig& c) { c.validator.same_overlap = -2.0; }},
    {"24a a find's overlap", [](FrontEndConfig& c) { c.validator.trusted_overlap = 0.0; }},
    {"24b, 28a sees through walls", [](FrontEndConfig& c) { c.validator.free_space_violation = kNever; }},
    {"24c a find much worse", [](FrontEndConfig& c) { c.validator.much_worse = kNever; }},
    {"24d a find the gyro contradicts", [](FrontEndConfig& c) { c.validator.gyro_error = kNever; }},
    {"26 innovation gate", [](FrontEndConfig& c) { c.ekf.max_rejected_poses = -1; }},
    {"26a third refusal believed", [](FrontEndConfig& c) { c.ekf.max_rejected_poses = kOften; }},
    {"26d rejections that agree", [](FrontEndConfig& c) { c.ekf.same_error = kNever; }},
    {"26b no farther than 1 km", [](FrontEndConfig& c) { c.ekf.farthest_pose = kNever; }},
    {"27 search", [](FrontEndConfig& c) { c.validator.trusted_overlap = 2.0; }},
    {"27a window grows", [](FrontEndConfig& c) { c.registration.most_widened = 0; }},
    {"27b ambiguous", [](FrontEndConfig& c) { c.search.ambiguity = kNever; }},
    {"27d slide", [](FrontEndConfig& c) { c.search.clear_gain = 2.0F; }},
    {"28 failures make a keyframe", [](FrontEndConfig& c) { c.tracking.degraded_after = kLongSilence; }},
    {"28b scans against odometry", [](FrontEndConfig& c) { c.scan_monitor.contradiction = kNever; }},
    {"28c scans against a gyro that rested", [](FrontEndConfig& c) { c.heading_monitor.contradiction = kNever; }},
    {"28d walls in the open", [](FrontEndConfig& c) { c.validator.walls_in_the_open = kNever; }},
    {"30 lidar's mount found", [](FrontEndConfig& c) { c.mount_monitor.mostly = kNever; }},
    {"30a lidar's mount considered",
     [](FrontEndConfig& c) { c.lidar.systematic.mount_yaw = c.lidar.systematic.mount_offset = 0.0; }},
    {"31 errors of all ranges and bearings considered",
     [](FrontEndConfig& c) { c.lidar.systematic.range_bias = c.lidar.systematic.bearing_scale = 0.0; }},
    {"32 a place that is not known", [](FrontEndConfig& c) { c.tracking.lost_position_sigma = kNever; }},
    {"33 gyro judged", [](FrontEndConfig& c) { c.gyro_monitor.rejected = kNever, c.gyro_monitor.least = 0; }},
});

}  // namespace

std::span<const Rule> frontEndRules() { return kRules; }

}  // namespace slam
