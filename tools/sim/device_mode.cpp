// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/device_mode.hpp"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <optional>
#include <sys/resource.h>
#include <unistd.h>

#include "runtime/clock.hpp"
#include "runtime/worker.hpp"
#include "tools/common/program.hpp"
#include "tools/sim/board_emulator.hpp"
#include "tools/sim/can_bus.hpp"
#include "tools/sim/depth_server.hpp"
#include "tools/sim/lidar_emulator.hpp"
#include "tools/sim/lidar_model.hpp"
#include "tools/sim/log_mode.hpp"
#include "tools/sim/pseudo_terminal.hpp"
#include "tools/sim/simulation.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
constexpr Duration kBoardPeriod = 20ms;  // the board renews its values at 50 Hz
constexpr Duration kCanPeriod = 10ms;    // of the frames of wheels and IMU
constexpr Duration kAfterwards = 1s;     // standing at the end, so that the last pose is published
constexpr int kDepthNiceness = 5;        // of the thread that renders
constexpr Duration kLidarLag = 10ms;     // the emulator works this far behind the simulation, which has the poses

class DeviceSession {
 public:
  DeviceSession(const SimOptions& options, const std::filesystem::path& directory, const std::string& can)
      : options_(options),
        scene_(sceneFor(options)),
        simulation_(scene_, options.seed, monotonicNow()),
        lidar_model_(scene_.world, {}, options.seed),
        seen_(scene_.world, options.seed),
        lidar_([this](Timestamp stamp, double bearing) { return measure(stamp, bearing); }, LidarModel::kTurnRate),
        lidar_port_(directory / "lidar"),
        board_port_(directory / "board"),
        depth_server_(directory / "depth", scene_.world, options.seed,
                      [this](Timestamp stamp) { return viewpoint(stamp); }),
        started_(simulation_.now()),
        next_board_(simulation_.now()),
        next_can_(simulation_.now()) {
    if (!can.empty()) can_.emplace(can, options.seed);
  }

  void run() {
    Worker world({.name = "world", .rate = 1.0 / toSeconds(Simulation::kStep)}, [this] { stepWorld(); });
    Worker lidar({.name = "lidar"}, [this] { serveLidar(); });
    Worker board({.name = "board"}, [this] { serveBoard(); });
    Worker depth({.name = "depth"}, [this] { serveDepth(); });
    for (Worker* worker : {&world, &lidar, &board, &depth}) worker->start();
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    const timespec period{0, 100000000};
    while (!over() && sigtimedwait(&signals, nullptr, &period) < 0) showState();
    endProgress();
    for (Worker* worker : {&world, &lidar, &board, &depth}) worker->requestStop();
    for (Worker* worker : {&world, &lidar, &board, &depth}) worker->stop();
    std::vector<WaypointVisit> visits = simulation_.visits();
    for (WaypointVisit& visit : visits) visit.stamp += clock_offset_;
    writeTruth(options_, truth_, visits, seen_);
  }

 private:
  void stepWorld() {
    const std::lock_guard lock(mutex_);
    if (!released_ && lidar_.scanning() && (can_ || board_.greeted())) {
      released_ = true;
      released_at_ = simulation_.now();
      simulation_.release();
    }
    // Catch up with the clock: a late tick must not slow the world down.
    for (const Timestamp now = monotonicNow(); simulation_.now() < now;) {
      simulation_.step();
      scene_.world.setTime(simulation_.driveTime());
      truth_.push_back({simulation_.now() + clock_offset_, simulation_.robot().pose()});
      stepCan();
      if (simulation_.now() < next_board_) continue;
      next_board_ += kBoardPeriod;
      renewBoard();
    }
    if (!options_.truth_map.empty()) seen_.addView(simulation_.robot().pose(), simulation_.now());
    if (simulation_.finished() && finished_at_ == Timestamp{}) finished_at_ = simulation_.now();
  }

  void renewBoard() {
    const auto angles = simulation_.robot().encoderAngles();
    const ImuReading reading = simulation_.robot().readImu();
    robolink::Imu imu;
    for (std::size_t i = 0; i < 3; ++i) {
      imu.gyro[i] = static_cast<float>(reading.gyro[i]);
      imu.accel[i] = static_cast<float>(reading.accel[i]);
    }
    board_.renew(angles[0], angles[1], imu, toSeconds(simulation_.now() - started_));
  }

  void stepCan() {
    if (!can_ || simulation_.now() < next_can_) return;
    next_can_ += kCanPeriod;
    const ImuReading reading = simulation_.robot().readImu();
    CanReadings readings{.angles = simulation_.robot().encoderAngles()};
    for (std::size_t i = 0; i < 3; ++i) {
      readings.gyro[i] = static_cast<float>(reading.gyro[i]);
      readings.accel[i] = static_cast<float>(reading.accel[i]);
    }
    const auto half = static_cast<float>(simulation_.robot().pose().theta / 2.0);
    readings.attitude = {std::cos(half), 0.0F, 0.0F, std::sin(half)};
    can_->step(simulation_.now(), readings);
  }

  double measure(Timestamp stamp, double bearing) {
    const Pose2 pose = simulation_.history().at(stamp, 1s).value_or(simulation_.robot().pose());
    const double range = lidar_model_.measure(pose, bearing);
    if (range > 0.0) seen_.addBeam(pose, bearing, lidar_model_.trueRange(pose, bearing));
    return range;
  }

  void serveLidar() {
    std::array<std::uint8_t, 256> chunk;
    const ReadResult result = lidar_port_.stream().read(chunk, 2ms);
    std::vector<std::uint8_t> out;
    {
      const std::lock_guard lock(mutex_);
      const Timestamp now = std::min(monotonicNow(), simulation_.now()) - kLidarLag;
      lidar_.receive({chunk.data(), result.size}, now, out);
      lidar_.stream(now, out);
    }
    if (!out.empty()) lidar_port_.send(out);
  }

  void serveBoard() {
    std::array<std::uint8_t, 256> chunk;
    const ReadResult result = board_port_.stream().read(chunk, 50ms);
    std::vector<std::uint8_t> out;
    {
      const std::lock_guard lock(mutex_);
      board_.receive({chunk.data(), result.size}, out);
    }
    if (!out.empty()) board_port_.send(out);
  }

  /// Where the camera was at an instant; it renders without the lock.
  std::optional<DepthViewpoint> viewpoint(Timestamp stamp) {
    const std::lock_guard lock(mutex_);
    const auto pose = simulation_.history().at(stamp);
    if (!pose) return std::nullopt;
    return DepthViewpoint{*pose, simulation_.driveTime() - toSeconds(simulation_.now() - stamp)};
  }

  void serveDepth() {
    if (!depth_is_nice_) {  // rendering gives way to the other devices, whose bytes are due to the millisecond
      setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kDepthNiceness);
      depth_is_nice_ = true;
    }
    depth_server_.serve(100ms);
  }

  bool over() {
    const std::lock_guard lock(mutex_);
    const Timestamp now = simulation_.now();
    const bool time_up = options_.seconds > 0.0 && released_ && now - released_at_ > fromSeconds(options_.seconds);
    return time_up || (finished_at_ != Timestamp{} && now - finished_at_ > kAfterwards);
  }

  void showState() {
    const std::lock_guard lock(mutex_);
    const Pose2& pose = simulation_.robot().pose();
    char text[120];
    std::snprintf(text, sizeof text, "%s %5.1f s  x %6.2f m  y %6.2f m  heading %6.1f deg",
                  released_ ? "driving" : "waiting for a driver", toSeconds(simulation_.now() - started_), pose.x,
                  pose.y, pose.theta * 57.29578);
    showProgress(text);
  }

  SimOptions options_;
  std::mutex mutex_;  // guards all below but what says otherwise; none of these threads is real-time
  Scene scene_;
  Simulation simulation_;
  LidarModel lidar_model_;
  TruthRecorder seen_;
  LidarEmulator lidar_;
  BoardEmulator board_;
  PseudoTerminal lidar_port_, board_port_;
  DepthServer depth_server_;    // of its thread alone
  bool depth_is_nice_ = false;  // of the same
  Duration clock_offset_ = wallClockOffset();
  std::optional<CanBus> can_;
  Timestamp started_, next_board_, next_can_, released_at_{}, finished_at_{};
  bool released_ = false;
  std::vector<StampedPose> truth_;
};

}  // namespace

void playDevices(const SimOptions& options, const std::filesystem::path& directory, const std::string& can) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto session = std::make_unique<DeviceSession>(options, directory, can);
  std::printf("devices: %s %s %s\n", (directory / "lidar").c_str(), (directory / "board").c_str(),
              (directory / "depth").c_str());
  std::fflush(stdout);
  session->run();
}

}  // namespace slam::sim
