// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/log_mode.hpp"

#include <cmath>
#include <fstream>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "depth/depth_projection.hpp"
#include "mapping/map_files.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/sim/situation/situated_lidar.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{1700000000s};  // any epoch, the same for every run
constexpr Duration kBoardPeriod = 20ms;   // the board renews its values at 50 Hz
constexpr Duration kLead = 2s;            // driven before a log that begins on the move
constexpr double kElsewhere = 2.0;        // [m] at least that a kidnapped robot is carried

/// Plays the sensors of one simulated drive into a log.
class LogSession {
 public:
  LogSession(const SimOptions& options, const std::filesystem::path& file, DepthConsumer depth)
      : options_(options),
        scene_(sceneFor(options)),
        simulation_(scene_, options.seed, kStart),
        lidar_(scene_.world, options.situation, options.seed),
        random_(options.seed ^ 0xA0761D6478BD642FULL),
        odometry_(kNominalBase),
        seen_(scene_.world, options.seed),
        projection_({.extrinsics = {.x = DepthCamera::kExtrinsics.x, .z = DepthCamera::kHeight},
                     .floor_clearance = TruthRecorder::kRobotBand.bottom,
                     .robot_height = TruthRecorder::kRobotBand.top}),
        depth_(kStart, options.seed,
               options.depth ? [this](const DepthImage& image, const Pose2&) { addDepth(image); } : std::move(depth)),
        log_(file) {
    simulation_.release();
  }

  void run() {
    const Timestamp end = options_.seconds > 0.0 ? kStart + fromSeconds(options_.seconds) : Timestamp::max();
    const double step = toSeconds(Simulation::kStep);
    if (options_.situation.starts_moving) {
      while (simulation_.now() < kStart + kLead) simulation_.step();
    }
    next_board_ = simulation_.now();
    startTurn(simulation_.now());
    while (!simulation_.finished() && simulation_.now() < end) {
      kidnap();
      simulation_.step();
      lidar_.step(simulation_.robot().pose(), step);
      scene_.world.setTime(simulation_.driveTime());
      measureBeams();
      const Pose2& pose = simulation_.robot().pose();
      if (!options_.truth_map.empty()) seen_.addView(pose, simulation_.now());
      depth_.step(scene_.world, pose, simulation_.now());
      if (simulation_.now() >= next_board_) {
        next_board_ += kBoardPeriod;
        readBoard();
      }
    }
    if (!log_.flush()) throw std::runtime_error("cannot write all of the log; is the disk full?");
    writeTruth(options_, truth_, simulation_.visits(), seen_);
  }

 private:
  void startTurn(Timestamp stamp) {
    scan_->stamp = stamp;
    scan_->size = 0;
    scan_->range_min = static_cast<float>(LidarModel::kRangeMin);
    scan_->range_max = lidar_.claimedRangeMax();
  }

  void measureBeams() {
    const Situation& situation = options_.situation;
    const bool covered = simulation_.carried() && situation.kidnapping->covered;
    while (true) {
      const Timestamp stamp = scan_->stamp + fromSeconds(lidar_.beamTime() * scan_->size);
      if (stamp > simulation_.now()) return;
      const Pose2 pose = *simulation_.history().at(stamp, kBoardPeriod);
      auto [beam, of_world] = lidar_.look(pose, scan_->size, covered);
      const double bearing = lidar_.bearing(scan_->size);
      if (of_world) seen_.addBeam(pose, bearing, lidar_.trueRange(pose, bearing));
      if (situation.beam_times) beam.time_offset = static_cast<float>(toSeconds(stamp - scan_->stamp));
      scan_->push(beam);
      if (scan_->size < situation.beams) continue;
      const std::int64_t utime = toMicroseconds(scan_->stamp);
      truth_.push_back({fromMicroseconds(utime), *simulation_.history().at(scan_->stamp)});
      write(simulation_.now(), channel::kScan, toMessage(*scan_, utime));
      startTurn(stamp + fromSeconds(lidar_.beamTime()) + fromSeconds(lidar_.gap()));
    }
  }

  void kidnap() {
    const auto& kidnapping = options_.situation.kidnapping;
    if (!kidnapping || kidnapped_ || simulation_.driveTime() < kidnapping->time) return;
    kidnapped_ = true;
    const std::vector<Waypoint>& route = scene_.route;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i + 1 < route.size(); ++i) {
      if ((route[i].pose.translation() - simulation_.robot().pose().translation()).norm() > kElsewhere) {
        places.push_back(i);
      }
    }
    if (places.empty()) throw std::runtime_error("the route of " + scene_.name + " has no other place to carry it to");
    const std::size_t place = places[std::uniform_int_distribution<std::size_t>(0, places.size() - 1)(random_)];
    const double heading = std::uniform_real_distribution<double>(-std::numbers::pi, std::numbers::pi)(random_);
    simulation_.carryTo(place, heading, Kidnapping::kSeconds);
  }

  void addDepth(const DepthImage& image) {
    if (projection_.project(image) != DepthStatus::kOk) return;  // as the daemon does
    write(simulation_.now(), channel::kDepth, toMessage(projection_.laser(), toMicroseconds(image.stamp)));
  }

  void readBoard() {
    const Timestamp now = simulation_.now();
    const auto within = [&](const auto& span) { return span && span->contains(simulation_.driveTime()); };
    std::array<double, 2> angles = simulation_.robot().encoderAngles();
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const double turned = angles[i] - std::exchange(counters_[i].angle, angles[i]);
      if (within(options_.situation.wheels_dead)) counters_[i].missed += turned;
      angles[i] -= counters_[i].missed;
    }
    const WheelSample wheels{now, odometry_.add(angles[0], angles[1])};
    if (!within(options_.situation.wheels_away))
      write(now, channel::kWheels, toMessage(wheels, toMicroseconds(now), angles));
    const ImuReading reading = simulation_.robot().readImu();
    const ImuSample imu{now, Eigen::Vector3d(reading.gyro.data()), Eigen::Vector3d(reading.accel.data())};
    write(now, channel::kImu, toMessage(options_.situation.imu.apply(imu), toMicroseconds(now)));
  }

  template <typename Message>
  void write(Timestamp when, const char* channel, const Message& message) {
    if (!log_.writeMessage(toMicroseconds(when), channel, message)) {
      throw std::runtime_error("cannot write all of the log; is the disk full?");
    }
  }

  SimOptions options_;
  Scene scene_;
  Simulation simulation_;
  SituatedLidar lidar_;
  std::mt19937_64 random_;
  bool kidnapped_ = false;
  WheelOdometry odometry_;
  struct Counter {
    double angle = 0.0, missed = 0.0;  // [rad] of the encoder; what it left out
  };
  std::array<Counter, 2> counters_;
  TruthRecorder seen_;
  DepthProjection projection_;
  DepthSampler depth_;
  EventLogWriter log_;
  std::unique_ptr<LaserScan> scan_ = std::make_unique<LaserScan>();
  Timestamp next_board_ = kStart;
  std::vector<StampedPose> truth_;
};

}  // namespace

Scene sceneFor(const SimOptions& options) {
  Scene scene = makeScene(options.scene, options.seed, options.situation.scene);
  if (options.situation.starts_moving) {
    scene.settle = 0.0;
    for (Waypoint& waypoint : scene.route) {
      waypoint.stop = false;
      waypoint.pause = 0.0;
    }
  }
  if (options.speed > 0.0) scene.speed = options.speed;
  return scene;
}

void writeLog(const SimOptions& options, const std::filesystem::path& log, DepthConsumer depth) {
  LogSession(options, log, std::move(depth)).run();
}

void writeTruth(const SimOptions& options, const std::vector<StampedPose>& poses,
                const std::vector<WaypointVisit>& visits, const TruthRecorder& seen) {
  if (!options.truth.empty()) {
    TrajectoryWriter writer(options.truth);
    for (const StampedPose& row : poses) writer.write(toMicroseconds(row.stamp), row.pose);
    writer.close();
  }
  if (!options.waypoints.empty()) {
    TrajectoryWriter writer(options.waypoints);
    for (const WaypointVisit& visit : visits) writer.write(toMicroseconds(visit.stamp), visit.pose);
    writer.close();
  }
  if (!options.truth_map.empty()) writeMapFiles(options.truth_map, seen.bandMap());
  if (!options.truth_map_lidar.empty()) writeMapFiles(options.truth_map_lidar, seen.lidarMap());
}

}  // namespace slam::sim
