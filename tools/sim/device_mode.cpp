// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/device_mode.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
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

class DeviceSession {
 public:
  DeviceSession(const SimOptions& options, const std::filesystem::path& directory, const std::string& can,
                const std::array<int, 2>& nodes)
      : options_(options),
        scene_(sceneFor(options)),
        simulation_(scene_, options.seed, monotonicNow(), {}, geometryOf(options.base).base),
        lidar_model_(scene_.world, {}, options.seed),
        seen_(scene_.world, options.seed),
        lidar_(makeLidar(std::string(lidarModel(options.lidar)))),
        board_(makeBase(options.base)),
        imu_(makeImu(options.imu)),
        lidar_line_(options.lidar_tcp > 0 ? FaultyLine(options.lidar_tcp) : FaultyLine(directory / "lidar")),
        board_line_(directory / "board"),
        imu_line_(directory / "imu"),
        depth_server_(directory / "depth", scene_.world, options.seed,
                      [this](Timestamp stamp) { return viewpoint(stamp); }),
        script_(readScript(options.faults)),
        pipe_(directory / "faults"),
        started_(simulation_.now()),
        next_can_(simulation_.now()),
        next_imu_(simulation_.now()) {
    if (!can.empty())
      can_.emplace(can, options.seed, nodes, options.vesc ? can::Protocol::kVesc : can::Protocol::kOdrive);
  }

  void run() {
    collectFaults();  // what is wrong from the begin is so with the first byte
    Worker world({.name = "world", .rate = 1.0 / toSeconds(Simulation::kStep)}, [this] { stepWorld(); });
    Worker lidar({.name = "lidar"}, [this] { serveLidar(); });
    Worker board({.name = "board"}, [this] { serveBoard(); });
    Worker imu({.name = "imu"}, [this] { serveImu(); });
    Worker depth({.name = "depth"}, [this] { serveDepth(); });
    const auto workers = {&world, &lidar, &board, &imu, &depth};
    for (Worker* worker : workers) worker->start();
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    const timespec period{0, 100000000};
    while (!over() && sigtimedwait(&signals, nullptr, &period) < 0) {
      collectFaults();
      showState();
    }
    endProgress();
    for (Worker* worker : workers) worker->requestStop();
    for (Worker* worker : workers) worker->stop();
    std::vector<WaypointVisit> visits = simulation_.visits();
    for (WaypointVisit& visit : visits) visit.stamp += clock_offset_;
    writeTruth(options_, truth_, visits, seen_);
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
    if (!released_ && lidar_->scanning() && (can_ || board_->inUse())) {
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
      stepImu();
      board_->renew(simulation_.robot(), simulation_.now());
      if (options_.obey) simulation_.obey(board_->drive());
    }
    if (!options_.truth_map.empty()) seen_.addView(simulation_.robot().pose(), simulation_.now());
    if (simulation_.finished() && finished_at_ == Timestamp{}) finished_at_ = simulation_.now();
  }

  void stepCan() {
    if (!can_ || simulation_.now() < next_can_) return;
    injectAll(takeFaults("can"),
              [this](const Fault& fault) { return can_->emulator().inject(fault.kind, fault.value); });
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

  void stepImu() {
    if (simulation_.now() < next_imu_) return;
    next_imu_ += EmulatedImu::kPeriod;
    const ImuReading reading = simulation_.robot().readImu();
    if (imu_out_.size() < kImuBuffer) imu_->sample(reading.gyro, reading.accel, imu_out_);
  }

  double measure(Timestamp stamp, double bearing) {
    const Pose2 pose = simulation_.history().at(stamp, 1s).value_or(simulation_.robot().pose());
    const double range = lidar_model_.measure(pose, bearing);
    if (range > 0.0) seen_.addBeam(pose, bearing, lidar_model_.trueRange(pose, bearing));
    return range;
  }

  void serveLidar() {
    injectInto("lidar", [this](const Fault& fault) { return injectLidar(fault); });
    const std::vector<std::uint8_t> in = lidar_line_.receive(2ms);
    std::vector<std::uint8_t> out;
    {
      const std::lock_guard lock(mutex_);
      const Timestamp now = std::min(monotonicNow(), simulation_.now());  // which has the poses
      lidar_->receive(in, now, out);
      lidar_->stream(now, out);
    }
    lidar_line_.send(std::move(out), monotonicNow());
  }

  void serveBoard() {
    injectInto("board", [this](const Fault& fault) { return injectBoard(fault); });
    const std::vector<std::uint8_t> in = board_line_.receive(2ms);
    std::vector<std::uint8_t> out;
    {
      const std::lock_guard lock(mutex_);
      board_->exchange(in, simulation_.now(), out);
    }
    board_line_.send(std::move(out), monotonicNow());
  }

  void serveImu() {
    injectInto("imu", [this](const Fault& fault) {
      if (imu_line_.inject(fault.kind, fault.value)) return true;
      const std::lock_guard lock(mutex_);
      return imu_->inject(fault.kind, fault.value);
    });
    const std::vector<std::uint8_t> in = imu_line_.receive(2ms);
    std::vector<std::uint8_t> out;
    {
      const std::lock_guard lock(mutex_);
      imu_->receive(in, imu_out_);
      out.swap(imu_out_);
    }
    imu_line_.send(std::move(out), monotonicNow());
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

  std::vector<ScheduledFault> readScript(const std::filesystem::path& file) {
    if (file.empty()) return {};
    std::ifstream in(file);
    if (!in) throw std::runtime_error(file.string() + ": cannot be read");
    return readFaultScript(in, file.string());
  }

  /// Faults that are due, by the script or by the pipe, go to the threads of their devices.
  void collectFaults() {
    const std::lock_guard lock(mutex_);
    for (; next_fault_ < script_.size() && script_[next_fault_].at <= simulation_.now() - started_; ++next_fault_) {
      due_.push_back(script_[next_fault_].fault);
    }
    for (const std::string& line : pipe_.read()) {
      if (const auto fault = parseFault(line)) {
        due_.push_back(*fault);
      } else {
        std::fprintf(stderr, "slam-sim: no fault: %s; write DEVICE KIND [VALUE]\n", line.c_str());
      }
    }
  }

  /// Faults that are due for a device. With the lock held.
  std::vector<Fault> takeFaults(std::string_view device) {
    const auto others =
        std::stable_partition(due_.begin(), due_.end(), [&](const Fault& fault) { return fault.device == device; });
    std::vector<Fault> taken(due_.begin(), others);
    due_.erase(due_.begin(), others);
    return taken;
  }

  /// Hands a device its faults. @param inject returns false for one that it does not know
  template <typename Inject>
  static void injectAll(const std::vector<Fault>& faults, Inject&& inject) {
    for (const Fault& fault : faults) {
      if (inject(fault)) continue;
      std::fprintf(stderr, "slam-sim: the %s knows no fault \"%s\" of %g\n", fault.device.c_str(), fault.kind.c_str(),
                   fault.value);
    }
  }

  /// The same for a device with a thread of its own.
  template <typename Inject>
  void injectInto(std::string_view device, Inject&& inject) {
    std::vector<Fault> faults;
    {
      const std::lock_guard lock(mutex_);
      faults = takeFaults(device);
    }
    injectAll(faults, inject);
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
    injectInto("depth", [this](const Fault& fault) { return depth_server_.inject(fault.kind, fault.value); });
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
  std::unique_ptr<EmulatedLidar> lidar_;
  std::unique_ptr<EmulatedBase> board_;
  std::unique_ptr<EmulatedImu> imu_;
  std::vector<std::uint8_t> imu_out_;
  FaultyLine lidar_line_, board_line_, imu_line_;  // of their threads alone
  DepthServer depth_server_;                       // of its thread alone
  bool depth_is_nice_ = false;                     // of the same
  std::vector<ScheduledFault> script_;
  std::size_t next_fault_ = 0;
  FaultPipe pipe_;
  std::vector<Fault> due_;
  Duration clock_offset_ = wallClockOffset();
  std::optional<CanBus> can_;
  Timestamp started_, next_can_, next_imu_, released_at_{}, finished_at_{};
  bool released_ = false;
  std::vector<StampedPose> truth_;
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
