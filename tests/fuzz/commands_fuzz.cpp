// SPDX-License-Identifier: BSD-3-Clause
// The input is a sequence of what programs send to slamd: for each a byte that chooses it, then its fields. The
// messages are decoded and judged as the bus thread does, and carried out by front end, back end, mapper and map store,
// in one thread and a time of their own. Whatever is sent, the pose stays one of a robot, a far one is refused, and the
// map that is stored is read back as it was.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <unistd.h>

#include "app/log/log.hpp"
#include "app/map/map_keeper.hpp"
#include "bus/checked_decode.hpp"
#include "bus/drive_senders.hpp"
#include "bus/encoding.hpp"
#include "bus/freshness.hpp"
#include "bus/received.hpp"
#include "core/plausibility.hpp"
#include "drivers/speed_command.hpp"
#include "fuzz/fuzzing.hpp"
#include "slam/pipeline.hpp"
#include "store/map_codec.hpp"
#include "support/stored_map.hpp"

namespace slam {

void logLine(const LogLine&) {}  // of the map store's remarks, which would be millions

namespace {

using namespace std::chrono_literals;

enum Command : std::uint8_t {
  kScan,
  kSetPose,
  kWheels,
  kImu,
  kDrive,
  kJournal,
  kSave,
  kLoad,
  kReset,
  kMode,
  kPause,
  kCommands
};

constexpr int kMostCommands = 12;
constexpr int kMostTiles = 9;  // of the grid that a scan of a room 6 m wide reaches

/// A folder in memory.
struct Folder {
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  const std::filesystem::path path = "/dev/shm/slamd-fuzz-" + std::to_string(::getpid());
};

/// A turn of the lidar in a room. @param width, depth [m]
LaserScan scanIn(double width, double depth, Timestamp stamp) {
  constexpr int kBeams = 90;
  LaserScan scan;
  scan.stamp = stamp;
  for (int i = 0; i < kBeams; ++i) {
    const double bearing = 2.0 * std::numbers::pi * i / kBeams;
    const double range = 0.5 * std::min(width / std::max(1e-3, std::abs(std::cos(bearing))),
                                        depth / std::max(1e-3, std::abs(std::sin(bearing))));
    scan.push({static_cast<float>(range), static_cast<float>(bearing), 0.0F, 0.0F});
  }
  return scan;
}

class Robot {
 public:
  Robot() {
    config_.store.directory = folder_.path;
    config_.map = test::smallGrid();
    config_.front_end.reference.extent = 25.6;  // [m] else most of the time goes into the tables of each robot
    beginIn(keeper_.begin(now_));
  }

  void obey(Command command, fuzz::Input& input) {
    now_ += 100ms;
    switch (command) {
      case kScan:
        return takeScan(input);
      case kSetPose:
        return setPose({input.take<double>(), input.take<double>(), input.take<double>()});
      case kWheels:
        return takeWheels(input);
      case kImu:
        return takeImu(input);
      case kDrive:
        return drive(input);
      case kJournal:
        return journal();
      case kPause:
        now_ += std::chrono::milliseconds(input.take<std::uint16_t>());
        return;
      default:
        return aboutMap(command, input);
    }
  }
  void check() {
    const PoseEstimate pose = pipeline_->frontEnd().estimate(now_);
    FUZZ_CHECK(isPlausible(pose.T_map_base, kPlausible.stored_farthest));
    FUZZ_CHECK(pose.covariance.allFinite());
    FUZZ_CHECK(pipeline_->backEnd().keyframes().size() <= loaded_ + scans_);
    int tiles = 0;
    pipeline_->mapper().grid().tiles().forEachTile([&](TileIndex, const auto&) { ++tiles; });
    FUZZ_CHECK(tiles <= kMostTiles * (1 + loaded_ + scans_));
    if (const auto twist = speed_.at(now_)) FUZZ_CHECK(limits_.factor(*twist) > 0.999);
  }
  void end() {
    fuzz::Input none{fuzz::Bytes()};
    aboutMap(kSave, none);
  }

 private:
  void beginIn(const MapState& map) {
    Config config = config_;
    config.mode = keeper_.localises() ? RunMode::kLocalise : RunMode::kSlam;
    pipeline_ =
        std::make_unique<Pipeline>(PipelineConfig{frontEndConfig(config), backEndConfig(config), config.map}, map);
    loaded_ = map.keyframes.size();
    scans_ = 0;
  }

  void takeScan(fuzz::Input& input) {
    const auto width = input.take<std::uint8_t>() % 6 + 1, depth = input.take<std::uint8_t>() % 6 + 1;
    pipeline_->add(scanIn(width, depth, now_));
    ++scans_;
  }

  /// As BusThread::onCommand() and EstimatorThread::tick() do.
  void setPose(const Pose2& wanted) {
    command_t command{};
    command.verb = "set_pose";
    command.pose[0] = wanted.x, command.pose[1] = wanted.y, command.pose[2] = wanted.theta;
    const auto came = decodeChecked<command_t>(test::encoded(command));
    FUZZ_CHECK(came);
    const Pose2 given{came->pose[0], came->pose[1], came->pose[2]};
    const bool refused = !implausibilityOf(given).empty();
    const bool near = std::abs(given.x) <= 10e3 && std::abs(given.y) <= 10e3;
    FUZZ_CHECK(near || refused);
    if (refused) return;
    pipeline_->setPose(given, Eigen::Vector3d(0.2, 0.2, 0.1));
    const Pose2 error = between(given, pipeline_->frontEnd().estimate(pipeline_->frontEnd().newestStamp()).T_map_base);
    FUZZ_CHECK(std::hypot(error.x, error.y) < 0.01 && std::abs(error.theta) < 0.01);
  }

  /// As BusThread::receive() does. @return the sample at our time
  template <typename Message>
  auto received(const Message& message, SenderClocks::Stream stream) {
    Received<Message> came(test::encoded(message));
    if (!came) return std::move(came.sample);
    const Timestamp stamp = fromMicroseconds(came.message->utime);
    const auto mapped = clocks_.map(stream, stamp, Duration(0), now_);
    came.sample->stamp = stamp + mapped.shift;
    if (mapped.refusal != Refusal::kNone) came.sample.reset();
    return std::move(came.sample);
  }
  std::int64_t utimeFrom(fuzz::Input& input) {
    return toMicroseconds(now_) +
           std::int64_t{input.take<std::int32_t>()} * (input.take<std::uint8_t>() % 2 != 0 ? 1'000'000 : 1000);
  }
  void takeWheels(fuzz::Input& input) {
    wheels_t message{};
    message.utime = utimeFrom(input);
    message.x = input.take<double>(), message.y = input.take<double>(), message.theta = input.take<double>();
    if (const auto sample = received(message, SenderClocks::kWheels)) pipeline_->add(*sample);
  }
  void takeImu(fuzz::Input& input) {
    imu_t message{};
    message.utime = utimeFrom(input);
    for (double& rate : message.gyro) rate = input.take<double>();
    if (const auto sample = received(message, SenderClocks::kImu)) pipeline_->add(*sample);
  }

  /// As BusThread::onDrive() and a driver do.
  void drive(fuzz::Input& input) {
    drive_t message{};
    const auto sender = input.take<std::uint8_t>();
    message.utime = utimeFrom(input);
    message.vx = input.take<double>(), message.vy = input.take<double>(), message.omega = input.take<double>();
    const Received<drive_t> came(test::encoded(message));
    if (!came) return;
    const bool zero = message.vx == 0.0 && message.vy == 0.0 && message.omega == 0.0;
    const Timestamp stamp = fromMicroseconds(message.utime);
    const auto mapped = senders_.clock(sender, now_).map(SenderClocks::kDrive, stamp, Duration(0), now_);
    const Timestamp sent = stamp + mapped.shift;
    const bool taken = zero || (mapped.refusal == Refusal::kNone && isFreshCommand(sent, now_));
    if (!taken || !senders_.take(sender, zero, now_)) return;
    FUZZ_CHECK(speed_.give(*came.sample, zero ? now_ : std::min(sent, now_)));
    if (zero) FUZZ_CHECK(speed_.at(now_) && speed_.at(now_)->vx == 0.0 && speed_.at(now_)->omega == 0.0);
  }

  MapState stamped(MapState map) const {
    map.utime = toMicroseconds(now_);
    return map;
  }

  /// As MapCommands::carryOut() does, behind the checkpoint of the present map.
  void aboutMap(Command command, fuzz::Input& input) {
    const MapState map = stamped(pipeline_->state());
    if (keeper_.writes() && map.keyframes.size() > 0) {
      FUZZ_CHECK(keeper_.checkpoint(now_, map));
      checkStored(map);
    }
    const std::string name(1, static_cast<char>('a' + input.take<std::uint8_t>() % 4));
    try {
      if (command == kSave && name != keeper_.name() && map.keyframes.size() > 0 && keeper_.writes()) {
        keeper_.saveAs(name, map);
      }
      if (command == kLoad) beginIn(keeper_.load(name, now_));
      if (command == kMode) beginIn(keeper_.changeMode(!keeper_.localises(), now_));
      if (command != kReset || keeper_.localises()) return;
      keeper_.beginNew(now_);
      beginIn(MapState());
    } catch (const std::runtime_error& error) {  // answered
      FUZZ_CHECK(std::string(error.what()).find("damaged") == std::string::npos);
    }
  }

  void journal() {
    if (!keeper_.hasJournal()) return;  // nothing is stored yet
    const MapState map = stamped(pipeline_->state());
    FUZZ_CHECK(keeper_.journal(now_, map));
    checkStored(map);
  }
  void checkStored(const MapState& map) const {
    const auto read = [&] { return MapStore::load(config_.store.directory, keeper_.name(), config_.map).state; };
    const auto same = [&](const MapState& stored) {
      return encodeKeyframes(stored) == encodeKeyframes(map) && encodeEdges(stored) == encodeEdges(map) &&
             encodeState(stored) == encodeState(map);
    };
    FUZZ_CHECK_NO_THROW(same(read()));
  }

  const Folder folder_;
  Timestamp now_{1000s};
  Config config_;
  MapKeeper keeper_{config_};
  std::unique_ptr<Pipeline> pipeline_;
  int loaded_ = 0, scans_ = 0;  // keyframes that its map had, and scans since
  SenderClocks clocks_;
  DriveSenders senders_{DriveOrder::kFirst};
  SpeedLimits limits_;
  SpeedCommand speed_{limits_};
};

}  // namespace
}  // namespace slam

/// Stands in for the C library's, by which new maps are named: the same input is the same run at any time of day.
extern "C" std::time_t time(std::time_t* now) noexcept {
  constexpr std::time_t kTime = 1'000'000'000;  // [s] since 1970
  if (now != nullptr) *now = kTime;
  return kTime;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  fuzz::Input input({data, size});
  Robot robot;
  for (int i = 0; i < kMostCommands && !input.atEnd(); ++i) {
    robot.obey(static_cast<Command>(input.take<std::uint8_t>() % kCommands), input);
    robot.check();
  }
  robot.end();
  return 0;
}
