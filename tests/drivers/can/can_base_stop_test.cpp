// SPDX-License-Identifier: BSD-3-Clause
// Whether the wheels stop, whatever happens to the bus, to the drives and to slamd.
#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>
#include <random>

#include "drivers/can/can_base.hpp"
#include "drivers/can/fake_can_port.hpp"
#include "tools/sim/can/can_emulator.hpp"

namespace slam::can_base_stop_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTick = 5ms;
constexpr std::uint32_t kController = 0x4, kBusOff = 0x40, kRestarted = 0x100;  // classes of error frames
constexpr std::uint8_t kPassive = 0x20, kActive = 0x40;

/// An adapter with its queue of frames, as SocketCAN shows it: a frame that it takes is on the bus a little later, or
/// never. On the bus two drives that keep the last speed they heard.
struct Bus : test::FakeCanBus {
  static constexpr std::size_t kQueue = 200;  // [frames]
  static constexpr int kFramesPerTick = 16;   // of the bus, at 500 kbit/s

  bool there = true, up = true, bus_off = false, cable = true, powered = true;
  bool drives_heard = true;   ///< false: they get what is sent, but nothing comes from them
  bool tells_passive = true;  ///< the adapter reports when nobody acknowledges
  std::deque<can::Frame> queue;
  sim::CanEmulator drives;

  /// A speed that is on the bus now reaches the drives.
  bool usable() const { return there && up && !bus_off && cable && powered; }

  void remove() {
    there = false;
    open_error = pending_error = interface_error = ENODEV;
    queue.clear();
  }
  void bringBack() {
    there = true;
    open_error = 0;
    interface_error = up ? 0 : ENETDOWN;  // the driver closed its socket meanwhile, or has a dead one
  }
  void takeDown() {
    up = false;
    interface_error = pending_error = there ? ENETDOWN : ENODEV;
    queue.clear();
  }
  void bringUp() {
    up = true;
    if (there) interface_error = 0;
  }
  void goBusOff() {
    bus_off = true;
    putError(kBusOff);
    queue.clear();
  }
  void restart() {
    bus_off = false;
    putError(kRestarted);
    queue.clear();
  }
  void setCable(bool in) {
    cable = in;
    if (tells_passive && there && up && !bus_off) putError(kController, in ? kActive : kPassive);
  }
  void step() {
    std::vector<can::Frame> out;
    const auto noise = static_cast<float>(1e-3 * static_cast<double>(clock.time_since_epoch().count() / 5'000'000 % 7));
    drives.step(clock, {.gyro = {noise, 0.0F, 0.0F}}, out);
    for (const can::Frame& frame : out) {
      if (usable() && drives_heard) put(frame);
    }
    for (int i = 0; i < kFramesPerTick && !queue.empty() && cable; ++i) {
      if (usable()) drives.receive(queue.front());
      queue.pop_front();
    }
  }
};

class Port : public test::FakeCanPort {
 public:
  explicit Port(Bus& bus) : FakeCanPort(bus), adapter_(bus) {}
  int open(const std::string& interface, std::span<const std::uint32_t> ids) override {
    const int error = FakeCanPort::open(interface, ids);
    if (error != 0) return error;
    adapter_.incoming.clear();
    adapter_.pending_error = 0;
    return 0;
  }
  int send(const can::Frame& frame) override {
    ++adapter_.sends;
    if (!adapter_.open) return EBADF;
    if (!adapter_.there) return ENXIO;
    if (!adapter_.up) return ENETDOWN;
    if (adapter_.bus_off) return 0;  // without a carrier the kernel drops it, and calls that a success
    if (adapter_.queue.size() >= Bus::kQueue) return ENOBUFS;
    adapter_.queue.push_back(frame);
    adapter_.sent.push_back(frame);
    return 0;
  }

 private:
  Bus& adapter_;
};

/// Of an adapter that gets rid of its frames again after some attempts.
class DrainingPort : public Port {
 public:
  explicit DrainingPort(Bus& bus) : Port(bus), adapter_(bus) {}
  int send(const can::Frame& frame) override {
    if (++attempts_ == 20) adapter_.queue.clear();
    return Port::send(frame);
  }

 private:
  Bus& adapter_;
  int attempts_ = 0;
};

class CanBaseStop : public testing::Test {
 protected:
  CanBaseStop() { startSlamd(); }
  void startSlamd() {
    driver_.emplace(commanding(), Bus::now, CanBase::Sinks{[](const WheelAngles&) {}, [](const ImuSample&) {}},
                    std::make_unique<Port>(bus_));
  }
  void tick() {
    bus_.clock += kTick;
    driver_->tick();
    bus_.step();
  }
  void runFor(Duration time) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) tick();
  }
  static CanBaseConfig commanding() { return {.commands = true, .wheel_radius = 1.0, .half_track = 1.0}; }
  void driveFor(Duration time) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end; tick()) driver_->command({.omega = 1.0});
  }
  bool stand() const { return bus_.drives.drive() == std::array<float, 2>{}; }
  void startDriving() {
    driveFor(1s);
    ASSERT_FALSE(stand());
  }
  /// Of another program, or held by a drive that was reset.
  void setSpeeds(float turns) {  // [turns/s]
    for (const int node : {0x10, 0x18}) bus_.drives.receive(can::odrive::encodeInputVelocity(node, {turns, 0.0F}));
  }
  void setState(can::odrive::AxisState state) {
    for (const int node : {0x10, 0x18}) bus_.drives.receive(can::odrive::encodeAxisState(node, state));
  }
  /// Each drive's last frame that the interface took.
  bool lastAreZeros() const {
    const auto zero = [this](int node) {
      const auto of = [node](const can::Frame& frame) {
        return can::odrive::parseInputVelocity(node, frame).has_value();
      };
      const auto last = std::find_if(bus_.sent.rbegin(), bus_.sent.rend(), of);
      return last != bus_.sent.rend() && can::odrive::parseInputVelocity(node, *last)->velocity == 0.0F;
    };
    return zero(0x10) && zero(0x18);
  }
  /// @return how long they still turned
  Duration timeToStop(Duration limit = 5s) {
    const Timestamp begin = bus_.clock;
    while (!stand() && bus_.clock - begin < limit) tick();
    return bus_.clock - begin;
  }

  Bus bus_;
  std::optional<CanBase> driver_;
};

/// By what comes from the drives, or by what the adapter reports.
class CanBaseStopEither : public CanBaseStop, public testing::WithParamInterface<bool> {
 protected:
  /// Drives that are not heard cannot be driven: they fall silent then.
  void startDriving() {
    bus_.drives_heard = bus_.tells_passive = true;
    CanBaseStop::startDriving();
    bus_.drives_heard = bus_.tells_passive = GetParam();
  }
};
INSTANTIATE_TEST_SUITE_P(Heard, CanBaseStopEither, testing::Bool());

TEST_P(CanBaseStopEither, IsSentAtTheFirstTickOfASlamdThatNeverHadACommand) {
  startDriving();
  startSlamd();  // the one before was killed
  ASSERT_FALSE(stand());
  tick();
  EXPECT_TRUE(stand());
}

TEST_P(CanBaseStopEither, IsSentWhenAnAdapterIsBackAlthoughTheCommandBecameOldLongBefore) {
  startDriving();
  bus_.remove();
  driveFor(1s);
  runFor(2s);
  ASSERT_FALSE(stand()) << "nothing reaches them";
  bus_.bringBack();
  EXPECT_LE(timeToStop(), 100ms);
}

TEST_P(CanBaseStopEither, IsSentWhenAnInterfaceIsUpAgain) {
  for (const Duration away : {Duration(10ms), Duration(400ms), Duration(10s)}) {
    startDriving();
    bus_.takeDown();
    runFor(away);
    bus_.bringUp();
    runFor(away < 500ms ? 500ms - away : Duration(0));
    EXPECT_LE(timeToStop(), 100ms);
  }
}

TEST_P(CanBaseStopEither, IsSentAfterBusOff) {
  startDriving();
  bus_.goBusOff();
  runFor(3s);
  ASSERT_FALSE(stand());
  bus_.restart();
  EXPECT_LE(timeToStop(), 100ms);
}

TEST_P(CanBaseStopEither, IsSentAgainWhenTheControllerLostItWithinOneTick) {
  startDriving();
  bus_.cable = false;
  runFor(2s);
  ASSERT_TRUE(lastAreZeros()) << "they were taken; none reached the drives";
  bus_.cable = true;
  bus_.goBusOff();
  bus_.restart();
  ASSERT_FALSE(stand());
  EXPECT_LE(timeToStop(), 100ms);
}

TEST_P(CanBaseStopEither, IsSentAfterACableWasPulledUntilTheQueueWasFull) {
  startDriving();
  bus_.setCable(false);
  driveFor(3s);
  runFor(3s);
  ASSERT_EQ(bus_.queue.size(), Bus::kQueue);
  ASSERT_FALSE(stand());
  bus_.setCable(true);
  EXPECT_LE(timeToStop(), 100ms);
  runFor(1s);
  EXPECT_TRUE(stand());
}

TEST_P(CanBaseStopEither, IsAllThatIsSentWhenDrivesThatHadNoPowerAcknowledgeAgain) {
  startDriving();
  bus_.setCable(false);
  driveFor(3s);
  runFor(1s);
  ASSERT_EQ(bus_.queue.size(), Bus::kQueue);
  const std::string reason = driver_->wheelStatus().problem().words();
  EXPECT_THAT(reason, testing::HasSubstr(GetParam() ? "error-passive" : "no frames of the left wheel"));
  bus_.sent.clear();
  bus_.sends = 0;
  for (int i = 0; i < 12000; ++i) {
    tick();
    ASSERT_EQ(driver_->wheelStatus().problem().words(), reason) << "no news, nothing to log";
  }
  EXPECT_LE(bus_.sends, 12000) << "an attempt a tick";
  ASSERT_TRUE(bus_.sent.empty());
  bus_.setCable(true);
  runFor(1s);
  EXPECT_TRUE(stand());
  ASSERT_GE(bus_.sent.size(), 80U);
  for (const can::Frame& frame : bus_.sent)
    ASSERT_EQ(can::odrive::parseInputVelocity(frame.id == 0x20D ? 0x10 : 0x18, frame)->velocity, 0.0F);
}

TEST_P(CanBaseStopEither, IsSentToADriveWhateverSpeedItHolds) {
  startDriving();
  runFor(5s);
  setSpeeds(1.0F);
  ASSERT_FALSE(stand());
  EXPECT_LE(timeToStop(), 20ms);
  setState(can::odrive::AxisState::kIdle);
  bus_.powered = false;
  runFor(5s);
  setSpeeds(1.0F);
  setState(can::odrive::AxisState::kClosedLoop);
  bus_.powered = true;
  ASSERT_FALSE(stand());
  EXPECT_LE(timeToStop(), 20ms);
}

TEST_P(CanBaseStopEither, FeedsTheDrivesWatchdogsAsLongAsSlamdRuns) {
  bus_.drives.inject("watchdog", 0.5);
  runFor(5s);
  EXPECT_TRUE(bus_.drives.armed()) << "nobody ever drove";
  setState(can::odrive::AxisState::kIdle);
  runFor(5s);
  setState(can::odrive::AxisState::kClosedLoop);
  EXPECT_TRUE(bus_.drives.armed());
  startDriving();
  runFor(5s);
  EXPECT_TRUE(bus_.drives.armed()) << "after a pause";
  startDriving();
  for (int i = 0; i < 120; ++i) {  // slamd is gone
    bus_.clock += kTick;
    bus_.step();
  }
  EXPECT_FALSE(bus_.drives.armed());
  EXPECT_TRUE(stand());
  runFor(1s);
  setState(can::odrive::AxisState::kClosedLoop);
  EXPECT_FALSE(bus_.drives.armed()) << "its error is to be cleared first";
}

TEST_F(CanBaseStop, IsSentToBothWheelsWhileOneDriveIsIdle) {
  for (const char* kind : {"idle", "axis_error"}) {
    startDriving();
    bus_.drives.inject(kind, 1.0);
    driveFor(300ms);
    EXPECT_TRUE(lastAreZeros()) << kind;
    driveFor(10s);
    EXPECT_TRUE(lastAreZeros()) << "although SLAM_DRIVE goes on";
    bus_.drives.inject(kind, 0.0);
    runFor(1s);
    EXPECT_TRUE(stand()) << "until a new command comes";
  }
  startDriving();
}

TEST_F(CanBaseStop, GivesWayToAFreshCommand) {
  startDriving();
  bus_.takeDown();
  runFor(3s);
  bus_.bringUp();
  driveFor(400ms);
  EXPECT_FALSE(stand()) << "both drives have told that they obey";
  EXPECT_LE(timeToStop(), 500ms) << "half a second after the command";
}

TEST_F(CanBaseStop, IsNotReplacedByACommandThatIsOldAlready) {
  startSlamd();
  runFor(500ms);
  driver_->command({.vx = 0.5}, bus_.clock - 501ms);
  for (int i = 0; i < 400; ++i) {
    tick();
    ASSERT_TRUE(stand());
  }
  EXPECT_FALSE(bus_.sent.empty());
}

TEST_F(CanBaseStop, AtTheEndWaitsForRoomInTheQueue) {
  startDriving();
  bus_.setCable(false);
  driveFor(3s);
  ASSERT_EQ(bus_.queue.size(), Bus::kQueue);
  driver_.emplace(commanding(), Bus::now, CanBase::Sinks{}, std::make_unique<DrainingPort>(bus_));
  driver_->tick();
  driver_->stop();
  ASSERT_GE(bus_.queue.size(), 2U);
  ASSERT_LE(bus_.queue.size(), 4U) << "no more than it takes";
  bus_.setCable(true);
  bus_.step();
  EXPECT_TRUE(stand());
}

TEST_F(CanBaseStop, AtTheEndGivesUpOnAQueueThatStaysFull) {
  startDriving();
  bus_.setCable(false);
  driveFor(3s);
  driver_->stop();
  EXPECT_FALSE(bus_.open);
  EXPECT_EQ(bus_.queue.size(), Bus::kQueue);
}

TEST_F(CanBaseStop, IsAsSoonAfterABusThatFailedAgainAndAgain) {
  for (const Duration away : {1000ms, 640ms, 1300ms, 830ms, 1900ms, 1100ms, 480ms, 1500ms}) {
    driveFor(110ms);
    bus_.powered = false;
    driveFor(away);
    bus_.powered = true;
  }
  startDriving();
  bus_.drives_heard = false;
  driveFor(400ms);
  EXPECT_TRUE(lastAreZeros()) << "although SLAM_DRIVE goes on";
  EXPECT_TRUE(stand());
}

/// Whatever happens, in any order: a tenth of a second after the drives can be reached they stand, if no command is
/// fresh, or one of them is idle or silent.
class CanBaseStopAlways : public CanBaseStop, public testing::WithParamInterface<unsigned> {
 protected:
  void happen(int what) {
    switch (what) {
      case 0:
        return bus_.there ? bus_.remove() : bus_.bringBack();
      case 1:
        return bus_.up ? bus_.takeDown() : bus_.bringUp();
      case 2:
        return bus_.bus_off ? bus_.restart() : bus_.goBusOff();
      case 3:
        return bus_.setCable(!bus_.cable);
      case 4:
        bus_.powered = !bus_.powered;
        return;
      case 5:  // too short to be seen as a state
        bus_.takeDown();
        return bus_.bringUp();
      case 6:
        bus_.goBusOff();
        return bus_.restart();
      case 7:  // killed
        startSlamd();
        disturbed_ = bus_.clock;
        return;
      case 8:
        driver_->stop();
        startSlamd();
        disturbed_ = bus_.clock;
        return;
      case 9:
      case 10:
      case 11:
        return repair();
      case 12:
        disturbed_ = bus_.clock;
        return setSpeeds(1.0F);
      case 13:
        bus_.drives_heard = !bus_.drives_heard;
        return;
      case 14:
        return bus_.drives.receive(can::odrive::encodeAxisState(0x10, can::odrive::AxisState::kIdle));
      default:
        driving_ = !driving_;
    }
  }

  void repair() {
    if (!bus_.there) bus_.bringBack();
    if (!bus_.up) bus_.bringUp();
    if (bus_.bus_off) bus_.restart();
    if (!bus_.cable) bus_.setCable(true);
    bus_.powered = bus_.drives_heard = true;
    setState(can::odrive::AxisState::kClosedLoop);
  }

  std::mt19937 random_{GetParam()};
  bool driving_ = false;
  Timestamp disturbed_{};  // slamd began anew, or another program drove
};

TEST_P(CanBaseStopAlways, LeavesNoWheelTurning) {
  bus_.tells_passive = GetParam() % 4 < 2;
  Timestamp commanded{}, obeyed{}, unusable{}, next{};
  std::string story;
  int turned = 0, stood = 0;
  for (const Timestamp end = bus_.clock + 300s; bus_.clock < end;) {
    if (bus_.clock >= next) {
      const auto longest = random_() % 2 == 0 ? 20 : 400;  // drawn first, whatever the compiler
      next = bus_.clock + 5ms * (random_() % longest);
      const int what = static_cast<int>(random_() % 19);
      happen(what);
      story += std::to_string(what) + " ";
    }
    if (driving_) {
      driver_->command({.omega = static_cast<double>(1 + random_() % 5) / 5.0});
      commanded = bus_.clock;
    }
    tick();
    if (!bus_.usable()) unusable = bus_.clock;
    if (bus_.drives.armed() && bus_.drives_heard) obeyed = bus_.clock;
    if (!stand()) ++turned;
    const Timestamp to_stop = std::min(commanded + 500ms, obeyed + 350ms);
    if (bus_.clock - std::max({unusable, disturbed_, to_stop}) <= 100ms) continue;
    ++stood;
    ASSERT_TRUE(stand() && lastAreZeros()) << "after " << story;
  }
  EXPECT_GT(turned, 500) << "ticks";
  EXPECT_GT(stood, 500) << "ticks";
}

INSTANTIATE_TEST_SUITE_P(Seeds, CanBaseStopAlways, testing::Range(1U, 41U));

}  // namespace
}  // namespace slam::can_base_stop_test
