// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/device_mode.hpp"

#include <algorithm>
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
#include "tools/sim/base/emulated_base.hpp"
#include "tools/sim/can/can_bus.hpp"
#include "tools/sim/depth/depth_server.hpp"
#include "tools/sim/faults/fault_script.hpp"
#include "tools/sim/faults/faulty_line.hpp"
#include "tools/sim/imu/emulated_imu.hpp"
#include "tools/sim/lidar/cola_emulator.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"
#include "tools/sim/log_mode.hpp"
#include "tools/sim/robot/simulation.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kImuBuffer = 4096;  // [bytes] of the line
constexpr Duration kCanPeriod = 10ms;     // of the frames of wheels and IMU
constexpr Duration kAfterwards = 1s;      // standing at the end, so that the last pose is published
constexpr int kDepthNiceness = 5;         // of the thread that renders

/// Bytes go to and fro between a line and what is at its end. @param exchange takes what came and appends what leaves
template <typename Exchange>
void serve(FaultyLine& line, Exchange&& exchange) {
  const std::vector<std::uint8_t> in = line.receive(2ms);
  std::vector<std::uint8_t> out;
  exchange(in, out);
  line.send(std::move(out), monotonicNow());
}

/// A stand-alone IMU on its line: samples are one thread's, bytes another's.
class ImuUnit {
 public:
  ImuUnit(const std::string& driver, const std::filesystem::path& path, Timestamp begin)
      : imu_(makeImu(driver)), line_(path), next_(begin) {}

  void step(RobotModel& robot, Timestamp now) {
    if (now < next_) return;
    next_ += EmulatedImu::kPeriod;
    const ImuReading reading = robot.readImu();
    const std::lock_guard lock(mutex_);
    if (out_.size() < kImuBuffer) imu_->sample(reading.gyro, reading.accel, out_);
  }
  bool inject(const Fault& fault) {
    if (line_.inject(fault.kind, fault.value)) return true;
    const std::lock_guard lock(mutex_);
    return imu_->inject(fault.kind, fault.value);
  }
  void serve() {
    sim::serve(line_, [this](const auto& in, auto& out) {
      const std::lock_guard lock(mutex_);
      imu_->receive(in, out_);
      out.swap(out_);
    });
  }

 private:
  std::mutex mutex_;  // guards the unit and its bytes
  std::unique_ptr<EmulatedImu> imu_;
  std::vector<std::uint8_t> out_;
  FaultyLine line_;  // of its thread alone
  Timestamp next_;   // sample, of the world's thread alone
};

/// What was true of a drive.
class DriveTruth {
 public:
  DriveTruth(const World& world, std::uint64_t seed) : seen_(world, seed) {}

  void add(Timestamp stamp, const Pose2& pose) { poses_.push_back({stamp + clock_offset_, pose}); }
  TruthRecorder& seen() { return seen_; }
  void write(const SimOptions& options, std::vector<WaypointVisit> visits) const {
    for (WaypointVisit& visit : visits) visit.stamp += clock_offset_;
    writeTruth(options, poses_, visits, seen_);
  }

 private:
  Duration clock_offset_ = wallClockOffset();
  std::vector<StampedPose> poses_;
  TruthRecorder seen_;
};

/// The wheels and the IMU on a CAN interface.
class CanUnit {
 public:
  CanUnit(const std::string& interface, const SimOptions& options, const std::array<int, 2>& nodes, Timestamp begin)
      : bus_(interface, options.seed, nodes, options.vesc ? can::Protocol::kVesc : can::Protocol::kOdrive),
        next_(begin) {}

  bool due(Timestamp now) const { return now >= next_; }
  bool inject(const Fault& fault) { return bus_.emulator().inject(fault.kind, fault.value); }
  void step(RobotModel& robot, Timestamp now) {
    next_ += kCanPeriod;
    const ImuReading reading = robot.readImu();
    CanReadings readings{.angles = robot.encoderAngles()};
    for (std::size_t i = 0; i < 3; ++i) {
      readings.gyro[i] = static_cast<float>(reading.gyro[i]);
      readings.accel[i] = static_cast<float>(reading.accel[i]);
    }
    const auto half = static_cast<float>(robot.pose().theta / 2.0);
    readings.attitude = {std::cos(half), 0.0F, 0.0F, std::sin(half)};
    bus_.step(now, readings);
  }

 private:
  CanBus bus_;
  Timestamp next_;
};

/// When a drive begins, and when it is over.
class Course {
 public:
  explicit Course(Timestamp begin) : begin_(begin) {}

  Duration elapsed(Timestamp now) const { return now - begin_; }
  bool isReleased() const { return released_.has_value(); }
  void release(Timestamp now) { released_ = now; }
  void finish(Timestamp now) {
    if (!finished_) finished_ = now;
  }
  /// @param seconds [s] after the release; 0: without limit
  bool isOver(Timestamp now, double seconds) const {
    const bool time_up = seconds > 0.0 && released_ && now - *released_ > fromSeconds(seconds);
    return time_up || (finished_ && now - *finished_ > kAfterwards);
  }

 private:
  Timestamp begin_;
  std::optional<Timestamp> released_, finished_;
};

class DeviceSession {
 public:
  DeviceSession(const SimOptions& options, const std::filesystem::path& directory, const std::string& can,
                const std::array<int, 2>& nodes)
      : options_(options),
        scene_(sceneFor(options)),
        simulation_(scene_, options.seed, monotonicNow(), {}, geometryOf(options.base).base),
        lidar_model_(scene_.world, {}, options.seed),
        truth_(scene_.world, options.seed),
        lidar_(makeLidar(std::string(lidarModel(options.lidar)))),
        board_(makeBase(options.base)),
        lidar_line_(options.lidar_tcp > 0 ? FaultyLine(options.lidar_tcp) : FaultyLine(directory / "lidar")),
        board_line_(directory / "board"),
        depth_server_(directory / "depth", scene_.world, options.seed,
                      [this](Timestamp stamp) { return viewpoint(stamp); }),
        faults_(options.faults, directory / "faults"),
        course_(simulation_.now()),
        imu_(options.imu, directory / "imu", simulation_.now()) {
    if (!can.empty()) can_.emplace(can, options, nodes, simulation_.now());
  }

  void run() {
    faults_.collect(Duration(0));  // what is wrong from the begin is so with the first byte
    Worker world({.name = "world", .rate = 1.0 / toSeconds(Simulation::kStep)}, [this] { stepWorld(); });
    Worker lidar({.name = "lidar"}, [this] { serveLidar(); });
    Worker board({.name = "board"}, [this] { serveBoard(); });
    Worker imu({.name = "imu"}, [this] {
      faults_.deliver("imu", [this](const Fault& fault) { return imu_.inject(fault); });
      imu_.serve();
    });
    Worker depth({.name = "depth"}, [this, is_nice = false]() mutable {
      // Rendering gives way to the other devices, whose bytes are due to the millisecond.
      if (!std::exchange(is_nice, true)) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kDepthNiceness);
      faults_.deliver("depth", [this](const Fault& fault) { return depth_server_.inject(fault.kind, fault.value); });
      depth_server_.serve(100ms);
    });
    const auto workers = {&world, &lidar, &board, &imu, &depth};
    for (Worker* worker : workers) worker->start();
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    const timespec period{0, 100000000};
    while (!over() && sigtimedwait(&signals, nullptr, &period) < 0) {
      faults_.collect(elapsed());
      showState();
    }
    endProgress();
    for (Worker* worker : workers) worker->requestStop();
    for (Worker* worker : workers) worker->stop();
    truth_.write(options_, simulation_.visits());
  }

 private:
  std::unique_ptr<EmulatedLidar> makeLidar(const std::string& driver) {
    const auto look = [this](Timestamp stamp, double bearing) { return measure(stamp, bearing); };
    for (const NamedIdentity& unit : namedIdentities()) {
      if (driver == unit.name) return std::make_unique<LidarEmulator>(look, unit.make().turn_rate, unit.make());
    }
    for (const ScipModel& model : scipModels()) {
      if (driver == model.name) return std::make_unique<ScipEmulator>(look, model);
    }
    for (const ColaModel& model : colaModels()) {
      if (driver == model.name) return std::make_unique<ColaEmulator>(look, model);
    }
    return std::make_unique<PacketEmulator>(look, driver);
  }

  void stepWorld() {
    const std::lock_guard lock(mutex_);
    if (!course_.isReleased() && lidar_->scanning() && (can_ || board_->inUse())) {
      course_.release(simulation_.now());
      simulation_.release();
    }
    // Catch up with the clock: a late tick must not slow the world down.
    for (const Timestamp now = monotonicNow(); simulation_.now() < now;) {
      simulation_.step();
      scene_.world.setTime(simulation_.driveTime());
      truth_.add(simulation_.now(), simulation_.robot().pose());
      stepCan();
      imu_.step(simulation_.robot(), simulation_.now());
      board_->renew(simulation_.robot(), simulation_.now());
      if (options_.obey) simulation_.obey(board_->drive());
    }
    if (!options_.truth_map.empty()) truth_.seen().addView(simulation_.robot().pose(), simulation_.now());
    if (simulation_.finished()) course_.finish(simulation_.now());
  }

  void stepCan() {
    if (!can_ || !can_->due(simulation_.now())) return;
    faults_.deliver("can", [this](const Fault& fault) { return can_->inject(fault); });
    can_->step(simulation_.robot(), simulation_.now());
  }

  double measure(Timestamp stamp, double bearing) {
    const Pose2 pose = simulation_.history().at(stamp, 1s).value_or(simulation_.robot().pose());
    const double range = lidar_model_.measure(pose, bearing);
    if (range > 0.0) truth_.seen().addBeam(pose, bearing, lidar_model_.trueRange(pose, bearing));
    return range;
  }

  void serveLidar() {
    faults_.deliver("lidar", [this](const Fault& fault) { return injectLidar(fault); });
    serve(lidar_line_, [this](const auto& in, auto& out) {
      const std::lock_guard lock(mutex_);
      const Timestamp now = std::min(monotonicNow(), simulation_.now());  // which has the poses
      lidar_->receive(in, now, out);
      lidar_->stream(now, out);
    });
  }

  void serveBoard() {
    faults_.deliver("board", [this](const Fault& fault) { return injectBoard(fault); });
    serve(board_line_, [this](const auto& in, auto& out) {
      const std::lock_guard lock(mutex_);
      board_->exchange(in, simulation_.now(), out);
    });
  }

  bool injectLidar(const Fault& fault) {
    if (!lidar_line_.inject(fault.kind, fault.value)) {
      const std::lock_guard lock(mutex_);
      return lidar_->inject(fault.kind, fault.value);
    }
    const std::lock_guard lock(mutex_);
    if (fault.kind == "unplug") lidar_->inject("reboot", 1.0);  // it has its power from the plug
    return true;
  }

  bool injectBoard(const Fault& fault) {
    const bool of_line = board_line_.inject(fault.kind, fault.value);
    const std::lock_guard lock(mutex_);
    if (!of_line) return board_->inject(fault.kind, fault.value);
    if (fault.kind == "unplug") board_->loseItsPlug();
    return true;
  }

  /// Where the camera was at an instant; it renders without the lock.
  std::optional<DepthViewpoint> viewpoint(Timestamp stamp) {
    const std::lock_guard lock(mutex_);
    const auto pose = simulation_.history().at(stamp);
    if (!pose) return std::nullopt;
    return DepthViewpoint{*pose, simulation_.driveTime() - toSeconds(simulation_.now() - stamp)};
  }

  Duration elapsed() {
    const std::lock_guard lock(mutex_);
    return course_.elapsed(simulation_.now());
  }

  bool over() {
    const std::lock_guard lock(mutex_);
    return course_.isOver(simulation_.now(), options_.seconds);
  }

  void showState() {
    const std::lock_guard lock(mutex_);
    const Pose2& pose = simulation_.robot().pose();
    char text[120];
    std::snprintf(text, sizeof text, "%s %5.1f s  x %6.2f m  y %6.2f m  heading %6.1f deg",
                  course_.isReleased() ? "driving" : "waiting for a driver",
                  toSeconds(course_.elapsed(simulation_.now())), pose.x, pose.y, pose.theta * 57.29578);
    showProgress(text);
  }

  SimOptions options_;
  std::mutex mutex_;  // guards all below but what says otherwise; none of these threads is real-time
  Scene scene_;
  Simulation simulation_;
  LidarModel lidar_model_;
  DriveTruth truth_;
  std::unique_ptr<EmulatedLidar> lidar_;
  std::unique_ptr<EmulatedBase> board_;
  FaultyLine lidar_line_, board_line_;  // of their threads alone
  DepthServer depth_server_;            // of its thread alone
  FaultQueue faults_;
  std::optional<CanUnit> can_;
  Course course_;
  ImuUnit imu_;
};

}  // namespace

void playDevices(const SimOptions& options, const std::filesystem::path& directory, const std::string& can,
                 const std::array<int, 2>& nodes) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto session = std::make_unique<DeviceSession>(options, directory, can, nodes);
  std::printf("devices: %s %s %s %s\n", (directory / "lidar").c_str(), (directory / "board").c_str(),
              (directory / "imu").c_str(), (directory / "depth").c_str());
  std::fflush(stdout);
  session->run();
}

}  // namespace slam::sim
