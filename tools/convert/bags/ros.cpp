// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/ros.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/samples.hpp"
#include "estimation/wheel_odometry.hpp"
#include "tools/convert/bags/ros_messages.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/range_census.hpp"

namespace slam {
namespace {

constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kOtherClock = 1000000;  // [us] delays that differ by more are of different clocks

/// Calls body(message) for each message of all files.
void forEachMessage(const std::vector<std::filesystem::path>& files, Recording* recording,
                    const std::function<void(const RosMessage&)>& body) {
  for (const auto& file : files) {
    const auto source = openRosFile(file);
    if (!source) throw std::runtime_error(file.string() + ": not a bag of ROS 1, nor .db3 or .mcap of ROS 2");
    for (RosMessage message; source->next(message);) body(message);
    if (recording == nullptr || source->damages() == 0) continue;
    recording->reject(source->firstDamage(), "left out");
    recording->rejected += source->damages() - 1;
    if (source->damages() > 1 || recording->rejected > 1) {
      recording->notes.push_back(file.filename().string() + " is damaged; what is sound was used");
    }
  }
}

/// Who publishes on a topic: its messages have one frame, one clock and, in ROS 1, one node.
struct Publisher {
  std::string node, frame, child_frame;
  int messages = 0, without_stamp = 0;
  int changes = 0;                  // messages that follow one of another publisher of the same frame
  std::int64_t least_delay = kMax;  // [us] from the stamp to the receipt
  std::int64_t last_delay = kMax;   // of its newest message with a stamp

  bool sameFrame(const Publisher& other) const { return frame == other.frame && child_frame == other.child_frame; }
};

/// Tells the publishers of a topic apart, message by message. The same messages give the same numbers.
class Publishers {
 public:
  /// @return the number of the one that published it
  std::size_t add(const RosMessage& message, const ros::Header& header, const std::string& child_frame = {}) {
    constexpr std::size_t kMost = 64;
    const std::int64_t delay = header.stamp > 0 ? message.received - header.stamp : kMax;
    Publisher seen{.node = message.topic->publisher, .frame = header.frame, .child_frame = child_frame};
    auto at = std::find_if(all_.begin(), all_.end(), [&](const Publisher& other) {
      const bool one_clock =
          delay == kMax || other.last_delay == kMax || std::abs(delay - other.last_delay) <= kOtherClock;
      return one_clock && other.node == seen.node && other.sameFrame(seen);
    });
    if (at == all_.end() && all_.size() >= kMost) at = std::prev(all_.end());
    if (at == all_.end()) at = all_.insert(at, seen);
    const auto index = static_cast<std::size_t>(at - all_.begin());
    ++at->messages;
    if (last_ < all_.size() && last_ != index && all_[last_].sameFrame(*at)) ++at->changes;
    if (delay == kMax) ++at->without_stamp;
    if (delay != kMax) at->least_delay = std::min(at->least_delay, at->last_delay = delay);
    last_ = index;
    return index;
  }
  const std::vector<Publisher>& all() const { return all_; }

  /// Of each, whether it is used: those of the frame with the most messages; of several that publish there in turn, as
  /// two drivers do, the one with the most. A driver that is started anew, or whose clock is set, follows itself.
  std::vector<bool> chosen() const {
    std::vector<bool> best;
    int most = 0;
    for (const Publisher& publisher : all_) {
      std::vector<bool> taken;
      int messages = 0, changes = 0, largest = 0;
      for (const Publisher& other : all_) {
        taken.push_back(other.sameFrame(publisher));
        if (!taken.back()) continue;
        messages += other.messages;
        changes += other.changes;
        largest = std::max(largest, other.messages);
      }
      if (2 * changes > messages - largest + 2) {
        for (std::size_t i = 0; i < all_.size(); ++i) taken[i] = &all_[i] == &publisher;
        messages = publisher.messages;
      }
      if (messages > most) {
        most = messages;
        best = taken;
      }
    }
    return best;
  }

 private:
  std::vector<Publisher> all_;
  std::size_t last_ = static_cast<std::size_t>(-1);
};

/// What a bag holds of a topic.
struct Topic {
  std::string type, refusal;
  int messages = 0, unread = 0;
  RangeCensus census;  // of scans that do not tell how far they reach
  Publishers publishers;
  std::vector<bool> chosen;  // of these; what follows is of them
  std::string frame, child_frame;
  int without_stamp = 0;
  std::int64_t least_delay = kMax;

  void choose() {
    chosen = publishers.chosen();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const Publisher& publisher = publishers.all()[i];
      if (!chosen[i]) continue;
      if (frame.empty()) frame = publisher.frame;
      if (child_frame.empty()) child_frame = publisher.child_frame;
      without_stamp += publisher.without_stamp;
      least_delay = std::min(least_delay, publisher.least_delay);
    }
  }
};

/// A frame in its parent.
struct Edge {
  std::string parent;
  Eigen::Isometry3d T_parent_child;
  bool moves = false;
  int transforms = 0;
};

struct Survey {
  std::map<std::string, Topic> topics;
  std::map<std::string, Edge> frames;  // by child
};

bool isTf(const std::string& type) { return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage"; }

void addTransforms(const std::vector<ros::Transform>& transforms, Survey& survey) {
  constexpr std::size_t kMostFrames = 2000;
  constexpr double kSame = 1e-3;  // [m, 1]
  for (const ros::Transform& transform : transforms) {
    if (survey.frames.size() >= kMostFrames && !survey.frames.contains(transform.child_frame)) continue;
    const auto [at, added] =
        survey.frames.emplace(transform.child_frame, Edge{transform.header.frame, transform.T_parent_child});
    Edge& edge = at->second;
    ++edge.transforms;
    if (!added && (edge.T_parent_child.matrix() - transform.T_parent_child.matrix()).cwiseAbs().maxCoeff() > kSame) {
      edge.moves = true;
    }
  }
}

/// Counts one message. @return false where it cannot be read
bool look(const RosMessage& message, Topic& topic, Survey& survey) {
  if (ros::isScan(topic.type)) {
    const auto scan = ros::readScan(message);
    if (!scan) return false;
    topic.publishers.add(message, scan->header);
    const auto beams = scan->scan.beams();
    for (std::size_t i = 0; i < beams.size() && scan->range_max == 0.0; ++i)
      topic.census.add(i, beams.size(), static_cast<double>(beams[i].range));
  } else if (topic.type == "sensor_msgs/Imu") {
    const auto imu = ros::readImu(message);
    if (!imu) return false;
    topic.publishers.add(message, imu->header);
  } else if (topic.type == "nav_msgs/Odometry") {
    const auto odometry = ros::readOdometry(message);
    if (!odometry) return false;
    topic.publishers.add(message, odometry->header, odometry->child_frame);
  } else if (topic.type == "sensor_msgs/JointState") {
    const auto joints = ros::readJoints(message);
    if (!joints) return false;
    topic.publishers.add(message, joints->header);
  } else {
    const auto transforms = ros::readTransforms(message);
    if (!transforms || transforms->empty()) return false;
    addTransforms(*transforms, survey);
    topic.publishers.add(message, transforms->front().header);
  }
  return true;
}

Survey surveyed(const std::vector<std::filesystem::path>& files, Recording& recording) {
  Survey survey;
  forEachMessage(files, &recording, [&](const RosMessage& message) {
    if (survey.topics.size() >= kMostTopics && !survey.topics.contains(message.topic->name)) return;
    const auto [at, added] = survey.topics.emplace(message.topic->name, Topic{});
    Topic& topic = at->second;
    if (added) {
      topic.type = message.topic->type;
      topic.refusal = ros::refusal(*message.topic);
    }
    ++topic.messages;
    if (topic.refusal.empty() && !look(message, topic, survey)) ++topic.unread;
  });
  for (auto& [name, topic] : survey.topics) topic.choose();
  return survey;
}

/// The topic that serves best: the one with the most messages of those that `rank` likes best.
std::string choose(const Survey& survey, const std::function<bool(const std::string& type)>& takes,
                   const std::function<int(const std::string& name)>& rank) {
  std::string best;
  std::pair<int, int> best_score{std::numeric_limits<int>::min(), 0};
  for (const auto& [name, topic] : survey.topics) {
    if (!takes(topic.type) || !topic.refusal.empty() || topic.unread == topic.messages) continue;
    const std::pair<int, int> score{rank(name), topic.messages - topic.unread};
    if (best.empty() || score > best_score) {
      best = name;
      best_score = score;
    }
  }
  return best;
}

bool contains(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != std::string::npos; });
}

/// A topic that was asked for by name must be there and be read.
void checkTopic(const Survey& survey, const std::string& name, const std::function<bool(const std::string&)>& takes,
                const char* option) {
  const auto at = survey.topics.find(name);
  std::string others;
  for (const auto& [other, topic] : survey.topics) {
    if (takes(topic.type)) others += " " + other;
  }
  if (at == survey.topics.end() || !takes(at->second.type)) {
    throw std::runtime_error(std::string(option) + " " + name + ": no such topic of this kind in the bag; it has" +
                             (others.empty() ? " none" : others));
  }
  if (!at->second.refusal.empty())
    throw std::runtime_error(std::string(option) + " " + name + ": " + at->second.refusal);
}

struct Place {
  Eigen::Isometry3d T_base_frame = Eigen::Isometry3d::Identity();
  bool moves = false;
};

/// Where a frame sits on the base, by the tree of frames.
std::optional<Place> placeOf(const Survey& survey, const std::string& base, const std::string& frame) {
  constexpr std::size_t kDeepest = 100;
  struct Ancestor {
    std::string name;
    Eigen::Isometry3d T_ancestor_frame;
    bool moves;
  };
  const auto ancestors = [&](const std::string& from) {
    std::vector<Ancestor> chain{{from, Eigen::Isometry3d::Identity(), false}};
    while (chain.size() < kDeepest) {
      const auto at = survey.frames.find(chain.back().name);
      if (at == survey.frames.end()) break;
      const Edge& edge = at->second;
      chain.push_back(
          {edge.parent, edge.T_parent_child * chain.back().T_ancestor_frame, chain.back().moves || edge.moves});
    }
    return chain;
  };
  const auto of_frame = ancestors(frame), of_base = ancestors(base);
  for (const Ancestor& a : of_frame) {
    for (const Ancestor& b : of_base) {
      if (a.name != b.name) continue;
      return Place{b.T_ancestor_frame.inverse() * a.T_ancestor_frame, a.moves || b.moves};
    }
  }
  return std::nullopt;
}

Pose2 planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))};
}

void mountLidar(const Survey& survey, const std::string& base, const Topic& scan, Recording& recording) {
  const auto place = placeOf(survey, base, scan.frame);
  if (!place || scan.frame.empty()) {
    recording.notes.push_back("no tf leads from " + base + " to the lidar's frame " + scan.frame +
                              ": its place is not known");
    return;
  }
  const Pose2 T_base_lidar = planar(place->T_base_frame);
  const double up = place->T_base_frame.linear()(2, 2);  // of the lidar's z axis
  recording.robot.lidar_x = T_base_lidar.x;
  recording.robot.lidar_y = T_base_lidar.y;
  recording.robot.lidar_yaw = T_base_lidar.theta;
  recording.robot.lidar_upside_down = up < 0.0;
  recording.robot.mount_source = "tf from " + base + " to " + scan.frame;
  constexpr double kLevel = 0.985;  // [1] cosine of 10 degrees
  if (std::abs(up) < kLevel) {
    recording.notes.emplace_back("the lidar is tilted by more than 10 degrees, which slamd does not take into account");
  }
  if (place->moves)
    recording.notes.push_back("tf moves the lidar's frame " + scan.frame + ": its first place was used");
}

/// The angles of left and right wheels among joints; empty: it has none.
class WheelJoints {
 public:
  std::optional<std::array<double, 2>> angles(const ros::Joints& joints) const {
    if (joints.names.size() != joints.positions.size()) return std::nullopt;
    std::array<double, 2> sum{}, count{};
    for (std::size_t i = 0; i < joints.names.size(); ++i) {
      const std::string& name = joints.names[i];
      if (name.find("wheel") == std::string::npos || contains(name, {"caster", "steer"})) continue;
      const bool left = contains(name, {"left", "_l_"}) || name.starts_with("l_") || name.ends_with("_l");
      const bool right = contains(name, {"right", "_r_"}) || name.starts_with("r_") || name.ends_with("_r");
      if (left == right || !std::isfinite(joints.positions[i])) continue;
      sum[right ? 1 : 0] += joints.positions[i];
      count[right ? 1 : 0] += 1.0;
    }
    if (count[0] == 0.0 || count[1] == 0.0) return std::nullopt;
    return std::array{sum[0] / count[0], sum[1] / count[1]};
  }
};

/// What is converted, and how.
struct Plan {
  std::string scan, odometry, imu, joints;  // topics; empty: none
  std::string odom_child;                   // frame whose transform is the odometry; empty: none
  std::string base;
  Eigen::Matrix3d imu_turn = Eigen::Matrix3d::Identity();  // from the IMU's axes to the base's
};

class Converter {
 public:
  Converter(const Survey& survey, const Plan& plan, const RosOptions& options, Recording& recording, LogOutput& log)
      : survey_(survey),
        plan_(plan),
        recording_(recording),
        log_(log),
        codes_(survey.topics.at(plan.scan).census.codes()),
        reckoning_(DifferentialBase{options.wheel_radius.value_or(DifferentialBase{}.wheel_radius),
                                    options.half_track.value_or(DifferentialBase{}.half_track)}) {}

  void add(const RosMessage& message) {
    const std::string& name = message.topic->name;
    const auto at = survey_.topics.find(name);
    if (at == survey_.topics.end() || !at->second.refusal.empty()) return;
    const Topic& topic = at->second;
    if (name == plan_.scan) addScan(message, topic);
    if (name == plan_.odometry) addOdometry(message, topic);
    if (name == plan_.imu) addImu(message, topic);
    if (name == plan_.joints) addJoints(message, topic);
    if (!plan_.odom_child.empty() && isTf(topic.type)) addTf(message, topic);
  }
  int thinned() const { return thinned_; }

 private:
  SensorRows& rows(const RosMessage& message, const Topic& topic) {
    SensorRows& rows = recording_.sensor(message.topic->name + " (" + topic.type + ")");
    if (rows.frame.empty()) rows.frame = topic.frame;
    return rows;
  }
  bool isChosen(const RosMessage& message, const ros::Header& header, const Topic& topic,
                const std::string& child_frame = {}) {
    return topic.chosen[publishers_[message.topic->name].add(message, header, child_frame)];
  }
  void leaveOutCodes(LaserScan& scan) const {
    for (int i = 0; i < scan.size; ++i) {
      float& range = scan.storage[static_cast<std::size_t>(i)].range;
      const auto is = [&](double code) { return isCode(static_cast<double>(range), code); };
      if (std::any_of(codes_.begin(), codes_.end(), is)) range = 0.0F;
    }
  }
  void refuse(SensorRows& rows, const RosMessage& message, const char* why) {
    recording_.reject(rows, message.topic->name + " at " + std::to_string(message.received) + " us", why);
  }
  /// [us] of a message by the clock of the scans; 0: not a time
  std::int64_t timeOf(const ros::Header& header, const RosMessage& message, const Topic& topic) const {
    const std::int64_t scans = survey_.topics.at(plan_.scan).least_delay, own = topic.least_delay;
    std::int64_t utime = header.stamp > 0 ? header.stamp : message.received;
    if (header.stamp <= 0 && scans != kMax && std::abs(scans) > kOtherClock) utime -= scans;
    if (header.stamp > 0 && own != kMax && scans != kMax && std::abs(own - scans) > kOtherClock) utime += own - scans;
    if (header.stamp > 0 && scans == kMax && std::abs(own) > kOtherClock) utime += own;
    constexpr std::int64_t kLatest = 2'300'000'000'000'000;  // [us] fromMessage() takes no later ones
    return utime > 0 && utime < kLatest ? utime : 0;
  }

  void addScan(const RosMessage& message, const Topic& topic) {
    SensorRows& sensor = rows(message, topic);
    auto scan = ros::readScan(message);
    if (scan && !isChosen(message, scan->header, topic)) return;
    const std::int64_t utime = scan ? timeOf(scan->header, message, topic) : 0;
    if (utime == 0) return refuse(sensor, message, scan ? "its stamp is not a time" : "a scan that does not decode");
    scan->scan.stamp = fromMicroseconds(utime);
    thinned_ = std::max(thinned_, scan->thinned);
    if (scan->range_max == 0.0) leaveOutCodes(scan->scan);
    if (recording_.scans == 0) {
      const double range_max = scan->range_max > 0.0 ? scan->range_max : topic.census.limit();
      recording_.robot.range_min = std::round(1e6 * scan->range_min) * 1e-6;  // they are 32 bits wide
      recording_.robot.range_max = std::round(1e6 * range_max) * 1e-6;
    }
    log_.add(message.received, scan->scan, utime);
    recording_.useScan(sensor, utime);
  }

  void addOdometry(const RosMessage& message, const Topic& topic) {
    SensorRows& sensor = rows(message, topic);
    const auto odometry = ros::readOdometry(message);
    if (odometry && !isChosen(message, odometry->header, topic, odometry->child_frame)) return;
    const std::int64_t utime = odometry ? timeOf(odometry->header, message, topic) : 0;
    if (utime == 0)
      return refuse(sensor, message, odometry ? "its stamp is not a time" : "odometry that does not decode");
    addWheels(message, sensor, utime, planar(odometry->T_odom_child), {});
  }

  void addTf(const RosMessage& message, const Topic& topic) {
    const auto transforms = ros::readTransforms(message);
    if (!transforms) return refuse(rows(message, topic), message, "transforms that do not decode");
    for (const ros::Transform& transform : *transforms) {
      if (transform.child_frame != plan_.odom_child) continue;
      const std::int64_t utime = timeOf(transform.header, message, topic);
      SensorRows& sensor = rows(message, topic);
      if (utime == 0) return refuse(sensor, message, "its stamp is not a time");
      addWheels(message, sensor, utime, planar(transform.T_parent_child), {});
    }
  }

  void addJoints(const RosMessage& message, const Topic& topic) {
    SensorRows& sensor = rows(message, topic);
    const auto joints = ros::readJoints(message);
    if (!joints) return refuse(sensor, message, "joint states that do not decode");
    const auto angles = WheelJoints().angles(*joints);
    if (!angles) return;  // of other joints
    const std::int64_t utime = timeOf(joints->header, message, topic);
    if (utime == 0) return refuse(sensor, message, "its stamp is not a time");
    addWheels(message, sensor, utime, reckoning_.add((*angles)[0], (*angles)[1]), *angles);
  }

  void addWheels(const RosMessage& message, SensorRows& sensor, std::int64_t utime, const Pose2& pose,
                 std::span<const double> angles) {
    log_.add(message.received, WheelSample{fromMicroseconds(utime), pose}, utime, angles);
    recording_.useWheels(sensor, utime);
  }

  void addImu(const RosMessage& message, const Topic& topic) {
    SensorRows& sensor = rows(message, topic);
    const auto imu = ros::readImu(message);
    if (imu && !isChosen(message, imu->header, topic)) return;
    const std::int64_t utime = imu ? timeOf(imu->header, message, topic) : 0;
    if (utime == 0)
      return refuse(sensor, message, imu ? "its stamp is not a time" : "an IMU reading that does not decode");
    log_.add(message.received,
             ImuSample{fromMicroseconds(utime), plan_.imu_turn * imu->gyro, plan_.imu_turn * imu->accel}, utime);
    recording_.useImu(sensor, utime);
  }

  const Survey& survey_;
  const Plan& plan_;
  Recording& recording_;
  LogOutput& log_;
  std::vector<double> codes_;  // [m] of scans that do not tell how far they reach
  WheelOdometry reckoning_;
  std::map<std::string, Publishers> publishers_;  // of topics, as in the survey
  int thinned_ = 1;
};

/// The frame of the base, and of the odometry in tf.
void findBase(const Survey& survey, const std::string& lidar_frame, Plan& plan) {
  const auto leads = [&](const std::string& base) {
    return !base.empty() && (survey.frames.contains(base) || placeOf(survey, base, lidar_frame)) &&
           placeOf(survey, base, lidar_frame);
  };
  std::string child = plan.odometry.empty() ? std::string() : survey.topics.at(plan.odometry).child_frame;
  if (plan.odometry.empty() && plan.joints.empty()) {
    for (const auto& [frame, edge] : survey.frames) {
      if (contains(edge.parent, {"odom"}) && edge.transforms > 1) plan.odom_child = child = frame;
    }
  }
  for (const std::string& base :
       {child, std::string("base_link"), std::string("base_footprint"), std::string("base")}) {
    if (!leads(base)) continue;
    plan.base = base;
    return;
  }
  plan.base = child.empty() ? "base_link" : child;
}

Plan planOf(const Survey& survey, const RosOptions& options, Recording& recording) {
  using ros::isScan;
  const auto isType = [](const char* type) { return [type](const std::string& other) { return other == type; }; };
  const auto isOdometry = isType("nav_msgs/Odometry"), isImu = isType("sensor_msgs/Imu"),
             isJoints = isType("sensor_msgs/JointState");
  if (!options.scan.empty()) checkTopic(survey, options.scan, isScan, "--scan");
  if (!options.odometry.empty()) checkTopic(survey, options.odometry, isOdometry, "--odometry");
  if (!options.imu.empty()) checkTopic(survey, options.imu, isImu, "--imu");
  const auto scanRank = [](const std::string& name) {
    const bool other = contains(name, {"rear", "back", "filtered", "depth", "camera", "ground", "safety"});
    return (name == "/scan" ? 2 : contains(name, {"front", "base_scan"}) ? 1 : 0) - (other ? 2 : 0);
  };
  const auto odometryRank = [](const std::string& name) {
    const bool other =
        contains(name, {"filter", "truth", "gps", "visual", "vo", "slam", "fused", "map", "laser", "rf2o"});
    return (contains(name, {"wheel"}) ? 2 : name == "/odom" ? 1 : 0) - (other ? 4 : 0);
  };
  const auto imuRank = [](const std::string& name) { return contains(name, {"raw"}) ? 0 : 1; };
  Plan plan;
  plan.scan = options.scan.empty() ? choose(survey, isScan, scanRank) : options.scan;
  plan.odometry = options.odometry.empty() ? choose(survey, isOdometry, odometryRank) : options.odometry;
  plan.imu = options.imu.empty() ? choose(survey, isImu, imuRank) : options.imu;
  const std::string joints = choose(survey, isJoints, [](const std::string&) { return 0; });
  if (plan.scan.empty()) {
    std::string why;
    for (const auto& [name, topic] : survey.topics) {
      if (!isScan(topic.type)) continue;
      why += "; " + name + ": " + (topic.refusal.empty() ? "its messages do not decode" : topic.refusal);
    }
    throw std::runtime_error("no lidar scan in it that can be read (sensor_msgs/LaserScan or MultiEchoLaserScan)" +
                             why);
  }
  const bool geometry = options.wheel_radius && options.half_track;
  if (!joints.empty() && options.odometry.empty() && geometry) {
    plan.joints = joints;
    plan.odometry.clear();
  }
  findBase(survey, survey.topics.at(plan.scan).frame, plan);
  if (plan.odometry.empty() && plan.joints.empty() && plan.odom_child.empty() && !joints.empty()) {
    plan.joints = joints;
    recording.notes.emplace_back(
        "the wheels' angles are those of joint states, and their size is not known: slamd's defaults were taken; give "
        "--wheel-radius and --half-track");
  }
  if (!plan.imu.empty()) {
    const std::string& frame = survey.topics.at(plan.imu).frame;
    if (const auto place = placeOf(survey, plan.base, frame); place && !frame.empty()) {
      plan.imu_turn = place->T_base_frame.linear();
    } else {
      recording.notes.push_back("no tf leads from " + plan.base + " to the IMU's frame " + frame +
                                ": its axes were taken for the base's");
    }
  }
  return plan;
}

std::string describe(const Publisher& publisher, const Publisher& chosen) {
  std::string text = "frame " + (publisher.frame.empty() ? "\"\"" : publisher.frame);
  if (publisher.child_frame != chosen.child_frame) text += ", of " + publisher.child_frame;
  if (publisher.node != chosen.node) text += ", node " + publisher.node;
  const bool stamped = publisher.least_delay != kMax && chosen.least_delay != kMax;
  const double off = stamped ? 1e-6 * static_cast<double>(chosen.least_delay - publisher.least_delay) : 0.0;
  char clock[64];
  std::snprintf(clock, sizeof(clock), ", clock %+.1f s off", off);
  if (std::abs(off) > 1e-6 * kOtherClock) text += clock;
  return text + ", " + std::to_string(publisher.messages) + " messages";
}

/// Says where other publishers of a topic are left out.
void notePublishers(const std::string& name, const Topic& topic, Recording& recording) {
  const auto& all = topic.publishers.all();
  const auto first =
      static_cast<std::size_t>(std::find(topic.chosen.begin(), topic.chosen.end(), true) - topic.chosen.begin());
  std::string others;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!topic.chosen[i]) others += (others.empty() ? "" : "; ") + describe(all[i], all[first]);
  }
  if (others.empty()) return;
  recording.notes.push_back(name + ": several drivers publish on it; the one with the most messages was used: " +
                            describe(all[first], all[first]) + "; left out: " + others);
}

void reportUnused(const Survey& survey, const Plan& plan, Recording& recording) {
  for (const auto& [name, topic] : survey.topics) {
    const bool used = name == plan.scan || name == plan.odometry || name == plan.imu || name == plan.joints;
    if (used || (isTf(topic.type) && topic.refusal.empty())) continue;
    std::string why = topic.refusal;
    if (why.empty())
      why = ros::isScan(topic.type) ? "another lidar was chosen; --scan " + name + " takes it"
                                    : "another topic was chosen";
    recording.unused.push_back(name + " (" + topic.type + "), " + std::to_string(topic.messages) + " messages: " + why);
    // A sensor whose messages are known by name and cannot be read is one that was not understood.
    if (!topic.refusal.empty() && ros::isRead(topic.type) && !ros::isScan(topic.type)) {
      SensorRows& rows = recording.sensor(name + " (" + topic.type + ")");
      for (int i = 0; i < topic.messages; ++i) recording.reject(rows, name, topic.refusal);
    }
  }
}

/// Files beside this one that look like parts of the same recording.
void noteOtherParts(const std::filesystem::path& in, Recording& recording) {
  std::string stem = in.stem().string();
  const std::size_t digits = stem.find_last_not_of("0123456789");
  if (digits == std::string::npos || digits + 1 == stem.size() || stem[digits] != '_') return;
  const int number = std::atoi(stem.substr(digits + 1, 6).c_str());
  for (const int other : {number - 1, number + 1}) {
    const auto part = in.parent_path() / (stem.substr(0, digits + 1) + std::to_string(other) + in.extension().string());
    if (other >= 0 && std::filesystem::exists(part)) {
      recording.notes.push_back("the recording is split, and this is one part of it: give the folder for all parts");
      return;
    }
  }
}

}  // namespace

Recording convertRos(const std::filesystem::path& in, const std::filesystem::path& out, const RosOptions& options) {
  const auto files = rosFiles(in);
  if (files.empty()) throw std::runtime_error(in.string() + ": no .bag, .db3 or .mcap in this folder");
  Recording recording;
  recording.format = "ROS bag" + (files.size() > 1 ? " of " + std::to_string(files.size()) + " files" : std::string());
  const Survey survey = surveyed(files, recording);
  Plan plan;
  try {
    plan = planOf(survey, options, recording);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(in.string() + ": " + error.what());
  }
  LogOutput log;
  Converter converter(survey, plan, options, recording, log);
  forEachMessage(files, nullptr, [&](const RosMessage& message) { converter.add(message); });
  if (recording.scans == 0) throw std::runtime_error(in.string() + ": no lidar scan in it that can be read");
  mountLidar(survey, plan.base, survey.topics.at(plan.scan), recording);
  reportUnused(survey, plan, recording);
  if (!std::filesystem::is_directory(in)) noteOtherParts(in, recording);
  if (converter.thinned() > 1) {
    recording.notes.push_back("the scans have more beams than a message holds: every " +
                              std::to_string(converter.thinned()) + "th was used");
  }
  if (!plan.joints.empty()) {
    recording.robot.wheel_radius = options.wheel_radius.value_or(DifferentialBase{}.wheel_radius);
    recording.robot.half_track = options.half_track.value_or(DifferentialBase{}.half_track);
  }
  const std::int64_t scan_delay = survey.topics.at(plan.scan).least_delay;
  for (const std::string& name : {plan.scan, plan.odometry, plan.imu, plan.joints}) {
    if (name.empty()) continue;
    const Topic& topic = survey.topics.at(name);
    if (name != plan.joints) notePublishers(name, topic, recording);
    if (topic.without_stamp > 0) {
      recording.notes.push_back(name + ": " + std::to_string(topic.without_stamp) +
                                " messages have no stamp; the time of their receipt was used");
    }
    const std::int64_t delay = topic.least_delay;
    if (delay != kMax && scan_delay != kMax && std::abs(delay - scan_delay) > kOtherClock) {
      recording.notes.push_back(
          name + ": its clock is another than the lidar's; its stamps were moved by the times of receipt");
    }
  }
  log.write(out, &recording);
  return recording;
}

}  // namespace slam
