// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <vector>

#include "estimation/wheel_odometry.hpp"
#include "tools/convert/assembler.hpp"
#include "tools/convert/bags/ros_messages.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/formats.hpp"

namespace slam {
namespace {

constexpr std::int64_t kOtherClock = 1000000;  // [us] delays that differ by more are of different clocks

/// Calls body(message) for each message of all files.
void forEachMessage(const std::vector<std::filesystem::path>& files, Assembler& to,
                    const std::function<void(const RosMessage&)>& body) {
  for (const auto& file : files) {
    const auto source = openRosFile(file);
    if (!source) throw std::runtime_error(file.string() + ": not a bag of ROS 1, nor .db3 or .mcap of ROS 2");
    for (RosMessage message; source->next(message);) body(message);
    if (!to.surveying() || source->damages() == 0) continue;
    to.recording.reject(source->firstDamage(), "left out");
    to.recording.rejected += source->damages() - 1;
    if (to.recording.rejected > 1) {
      to.recording.notes.push_back(file.filename().string() + " is damaged; what is sound was used");
    }
  }
}

/// Who publishes on a topic: its messages have one frame, one clock and, in ROS 1, one node.
struct Publisher {
  std::string node, frame, child_frame;
  int messages = 0, without_stamp = 0;
  int changes = 0;  // messages that follow one of another publisher of the same frame
  ReceiptDelay delay = {};
  std::optional<std::int64_t> last_delay = {};  // [us] of its newest message with a stamp

  bool sameFrame(const Publisher& other) const { return frame == other.frame && child_frame == other.child_frame; }
};

/// Tells the publishers of a topic apart, message by message. The same messages give the same numbers.
class Publishers {
 public:
  /// @return the number of the one that published it
  std::size_t add(const RosMessage& message, const ros::Header& header, const std::string& child_frame) {
    constexpr std::size_t kMost = 64;
    const auto delay = header.stamp > 0 ? std::optional(message.received - header.stamp) : std::nullopt;
    Publisher seen{.node = message.topic->publisher, .frame = header.frame, .child_frame = child_frame};
    auto at = std::find_if(all_.begin(), all_.end(), [&](const Publisher& other) {
      const bool one_clock = !delay || !other.last_delay || std::abs(*delay - *other.last_delay) <= kOtherClock;
      return one_clock && other.node == seen.node && other.sameFrame(seen);
    });
    if (at == all_.end() && all_.size() >= kMost) at = std::prev(all_.end());
    if (at == all_.end()) at = all_.insert(at, seen);
    const auto index = static_cast<std::size_t>(at - all_.begin());
    ++at->messages;
    if (last_ < all_.size() && last_ != index && all_[last_].sameFrame(*at)) ++at->changes;
    if (!delay) ++at->without_stamp;
    if (delay) at->delay.add(*(at->last_delay = delay));
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
  ReceiptDelay delay = {};

  void choose() {
    chosen = publishers.chosen();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const Publisher& publisher = publishers.all()[i];
      if (!chosen[i]) continue;
      if (frame.empty()) frame = publisher.frame;
      if (child_frame.empty()) child_frame = publisher.child_frame;
      without_stamp += publisher.without_stamp;
      delay.add(publisher.delay.least);
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
bool survey(const RosMessage& message, Topic& topic, Survey& survey) {
  const auto read = ros::read(message);
  if (!read) return false;
  const auto* transforms = std::get_if<std::vector<ros::Transform>>(&read->content);
  if (transforms != nullptr && transforms->empty()) return false;
  if (transforms != nullptr) addTransforms(*transforms, survey);
  topic.publishers.add(message, transforms != nullptr ? transforms->front().header : read->header, read->child_frame);
  const auto* scan = std::get_if<ros::Scan>(&read->content);
  if (scan == nullptr || scan->range_max != 0.0) return true;
  const auto beams = scan->scan.beams();
  for (std::size_t i = 0; i < beams.size(); ++i) topic.census.add(i, beams.size(), static_cast<double>(beams[i].range));
  return true;
}

bool contains(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != std::string::npos; });
}

/// The topic that was asked for by name, which must be there and be read; without one that which serves best: with the
/// most messages of those that `rank` likes best.
std::string choose(const Survey& survey, const std::string& asked, const char* option,
                   const std::function<bool(const std::string& type)>& takes,
                   const std::function<int(const std::string& name)>& rank) {
  std::string best, others;
  std::pair<int, int> best_score{std::numeric_limits<int>::min(), 0};
  for (const auto& [name, topic] : survey.topics) {
    if (!takes(topic.type)) continue;
    others += " " + name;
    if (name == asked && !topic.refusal.empty())
      throw std::runtime_error(std::string(option) + " " + name + ": " + topic.refusal);
    if (name == asked) return name;
    if (!topic.refusal.empty() || topic.unread == topic.messages) continue;
    const std::pair<int, int> score{rank(name), topic.messages - topic.unread};
    if (best.empty() || score > best_score) {
      best = name;
      best_score = score;
    }
  }
  if (asked.empty()) return best;
  throw std::runtime_error(std::string(option) + " " + asked + ": no such topic of this kind in the bag; it has" +
                           (others.empty() ? " none" : others));
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

/// [rad] of left and right wheels among joints; nullopt: they are others
std::optional<std::array<double, 2>> wheelAngles(const ros::Joints& joints) {
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

/// What is converted, and how.
struct Plan {
  std::string scan, odometry, imu, joints;  // topics; empty: none
  std::string odom_child;                   // frame whose transform is the odometry; empty: none
  std::string base;
  Eigen::Matrix3d imu_turn = Eigen::Matrix3d::Identity();  // from the IMU's axes to the base's
};

/// The frame of the base, and of the odometry in tf.
void findBase(const Survey& survey, const std::string& lidar_frame, Plan& plan) {
  const auto leads = [&](const std::string& base) { return !base.empty() && placeOf(survey, base, lidar_frame); };
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
  const auto isOdometry = isType(ros::kOdometry), isImu = isType(ros::kImu), isJoints = isType(ros::kJoints);
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
  plan.scan = choose(survey, options.scan, "--scan", isScan, scanRank);
  plan.odometry = choose(survey, options.odometry, "--odometry", isOdometry, odometryRank);
  plan.imu = choose(survey, options.imu, "--imu", isImu, imuRank);
  const std::string joints = choose(survey, {}, "", isJoints, [](const std::string&) { return 0; });
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
  const bool stamped = publisher.delay.known() && chosen.delay.known();
  const double off = stamped ? 1e-6 * static_cast<double>(chosen.delay.least - publisher.delay.least) : 0.0;
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
    if (used || (ros::isTf(topic.type) && topic.refusal.empty())) continue;
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

class Ros : public Reader {
 public:
  Ros(const std::filesystem::path& in, const RosOptions& options)
      : Reader(in),
        options_(options),
        base_{options.wheel_radius.value_or(DifferentialBase{}.wheel_radius),
              options.half_track.value_or(DifferentialBase{}.half_track)},
        reckoning_(base_),
        files_(rosFiles(in)) {
    if (files_.empty()) throw std::runtime_error(in.string() + ": no .bag, .db3 or .mcap in this folder");
  }

  void read(Assembler& to) override {
    forEachMessage(files_, to, [&](const RosMessage& message) {
      const std::string& name = message.topic->name;
      const auto at = survey_.topics.find(name);
      if (!to.surveying()) {
        if (at != survey_.topics.end() && at->second.refusal.empty()) use(message, at->second, to);
        return;
      }
      if (at == survey_.topics.end() && survey_.topics.size() >= kMostTopics) return;
      Topic& topic = survey_.topics[name];
      if (topic.messages++ == 0) {
        topic.type = message.topic->type;
        topic.refusal = ros::refusal(*message.topic);
      }
      if (topic.refusal.empty() && !survey(message, topic, survey_)) ++topic.unread;
    });
  }

  void decide(Assembler& to) override {
    to.recording.format =
        "ROS bag" + (files_.size() > 1 ? " of " + std::to_string(files_.size()) + " files" : std::string());
    for (auto& [name, topic] : survey_.topics) topic.choose();
    try {
      plan_ = planOf(survey_, options_, to.recording);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(in_.string() + ": " + error.what());
    }
    lidar_ = &survey_.topics.at(plan_.scan);
    to.codes = lidar_->census.codes();
  }

  void finish(Assembler& to) override {
    Recording& recording = to.recording;
    if (recording.scans == 0) throw std::runtime_error(in_.string() + ": no lidar scan in it that can be read");
    mountLidar(survey_, plan_.base, *lidar_, recording);
    reportUnused(survey_, plan_, recording);
    if (!std::filesystem::is_directory(in_)) noteOtherParts(in_, recording);
    if (thinned_ > 1) {
      recording.notes.push_back("the scans have more beams than a message holds: every " + std::to_string(thinned_) +
                                "th was used");
    }
    if (!plan_.joints.empty()) {
      recording.robot.wheel_radius = base_.wheel_radius;
      recording.robot.half_track = base_.half_track;
    }
    for (const std::string& name : {plan_.scan, plan_.odometry, plan_.imu, plan_.joints}) {
      if (name.empty()) continue;
      const Topic& topic = survey_.topics.at(name);
      if (name != plan_.joints) notePublishers(name, topic, recording);
      if (topic.without_stamp > 0) {
        recording.notes.push_back(name + ": " + std::to_string(topic.without_stamp) +
                                  " messages have no stamp; the time of their receipt was used");
      }
      if (hasOtherClock(topic)) {
        recording.notes.push_back(
            name + ": its clock is another than the lidar's; its stamps were moved by the times of receipt");
      }
    }
  }

 private:
  bool hasOtherClock(const Topic& topic) const {
    return topic.delay.known() && lidar_->delay.known() &&
           std::abs(topic.delay.least - lidar_->delay.least) > kOtherClock;
  }
  /// [us] of a message by the clock of the scans; 0: not a time
  std::int64_t timeOf(const ros::Header& header, const RosMessage& message, const Topic& topic) const {
    const bool stamped = header.stamp > 0, lidar_stamped = lidar_->delay.known();
    const std::int64_t scans = lidar_->delay.least, own = topic.delay.least;
    std::int64_t utime = stamped ? header.stamp : message.received;
    if (!stamped && lidar_stamped && std::abs(scans) > kOtherClock) utime -= scans;
    if (stamped && hasOtherClock(topic)) utime += own - scans;
    if (stamped && !lidar_stamped && std::abs(own) > kOtherClock) utime += own;
    constexpr std::int64_t kLatest = 2'300'000'000'000'000;  // [us] fromMessage() takes no later ones
    return utime > 0 && utime < kLatest ? utime : 0;
  }

  void use(const RosMessage& message, const Topic& topic, Assembler& to) {
    const std::string& name = message.topic->name;
    const bool tf = ros::isTf(topic.type) && !plan_.odom_child.empty();
    if (!tf && name != plan_.scan && name != plan_.odometry && name != plan_.imu && name != plan_.joints) return;
    Origin at{.sensor = name + " (" + topic.type + ")",
              .where = name + " at " + std::to_string(message.received) + " us",
              .received = message.received,
              .frame = topic.frame};
    if (!tf) to.rows(at);
    auto read = ros::read(message);
    if (!read) return to.refuse(at, ros::undecoded(topic.type));
    const bool joints = name == plan_.joints;
    const auto publisher = [&] { return publishers_[name].add(message, read->header, read->child_frame); };
    if (!tf && !joints && !topic.chosen[publisher()]) return;
    at.stamp = timeOf(read->header, message, topic);
    if (const auto* transforms = std::get_if<std::vector<ros::Transform>>(&read->content)) {
      for (const ros::Transform& transform : *transforms) {
        at.stamp = timeOf(transform.header, message, topic);
        if (transform.child_frame == plan_.odom_child) to.wheels(at, planar(transform.T_parent_child));
      }
    } else if (auto* scan = std::get_if<ros::Scan>(&read->content)) {
      addScan(at, *scan, topic, to);
    } else if (const auto* imu = std::get_if<ros::Imu>(&read->content)) {
      to.imu(at, plan_.imu_turn * imu->gyro, plan_.imu_turn * imu->accel);
    } else if (const auto* odometry = std::get_if<ros::Odometry>(&read->content)) {
      to.wheels(at, planar(odometry->T_odom_child));
    } else if (const auto angles = wheelAngles(std::get<ros::Joints>(read->content))) {
      to.wheels(at, at.stamp > 0 ? reckoning_.add((*angles)[0], (*angles)[1]) : Pose2{}, *angles);
    }
  }

  void addScan(const Origin& at, ros::Scan& scan, const Topic& topic, Assembler& to) {
    thinned_ = std::max(thinned_, at.stamp > 0 ? scan.thinned : 1);
    if (to.recording.scans == 0 && at.stamp > 0) {
      const double range_max = scan.range_max > 0.0 ? scan.range_max : topic.census.limit();
      to.recording.robot.range_min = std::round(1e6 * scan.range_min) * 1e-6;  // they are 32 bits wide
      to.recording.robot.range_max = std::round(1e6 * range_max) * 1e-6;
    }
    std::vector<double> written;
    if (scan.range_max == 0.0) {
      for (const Beam& beam : scan.scan.beams()) written.push_back(static_cast<double>(beam.range));
    }
    to.scan(at, scan.scan, {.written = written});
  }

  const RosOptions& options_;
  const DifferentialBase base_;
  WheelOdometry reckoning_;
  std::vector<std::filesystem::path> files_;
  Survey survey_;
  Plan plan_;
  const Topic* lidar_ = nullptr;                  // whose scans are used
  std::map<std::string, Publishers> publishers_;  // of topics, as in the survey
  int thinned_ = 1;
};

}  // namespace

Recording convertRos(const std::filesystem::path& in, const std::filesystem::path& out, const RosOptions& options) {
  return assemble(Ros(in, options), out);
}

}  // namespace slam
