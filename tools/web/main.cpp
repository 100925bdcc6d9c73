// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <poll.h>
#include <sys/signalfd.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "config/loader.hpp"
#include "runtime/clock.hpp"
#include "tools/common/program.hpp"
#include "tools/slamctl/remote.hpp"
#include "tools/web/access/token_file.hpp"
#include "tools/web/drive/drive_sender.hpp"
#include "tools/web/history/history_file.hpp"
#include "tools/web/web_server.hpp"

namespace {

using namespace std::chrono_literals;
using namespace slam;
constexpr auto kAnswerLimit = 20s;        // a large map on a slow disk
constexpr Duration kEventPeriod = 100ms;  // 10 Hz
constexpr auto kKeepPeriod = 5min;        // the last day is written to the disk

/// What the state follows: the newest messages on LCM, each checked before it is decoded.
class Listener {
 public:
  Listener(const std::string& url, SharedState& shared, FoxgloveHub& foxglove)
      : link_(url), shared_(shared), foxglove_(foxglove) {
    shared_.state.begin(monotonicNow());
    subscribe<pose_estimate_t>(channel::kSlamPose);
    subscribe<problems_t>(channel::kProblems);
    subscribe<health_t>(channel::kHealth);
    subscribe<scan_t>(channel::kScan);
    subscribe<depth_t>(channel::kDepth);
    subscribe<map_meta_t>(channel::kMapMeta);
    subscribe<map_edit_t>(channel::kMapEdits);
    subscribeTiles(channel::kMapTile, MapLayer::kBoth);
    subscribeTiles(channel::kMapLidar, MapLayer::kLidar);
    subscribeTiles(channel::kMapDepth, MapLayer::kDepth);
    subscribeWatched<wheels_t>(channel::kWheels);
    subscribeWatched<imu_t>(channel::kImu);
    subscribeWatched<odometry_t>(channel::kOdometry);
  }

  int descriptor() const { return link_.descriptor(); }
  void receive() {
    const std::lock_guard lock(linking_);
    link_.receive();
    link_.tend(monotonicNow());
  }
  /// SLAM_DRIVE, once; from any thread. @return false: it could not be sent
  bool drive(const Twist2& twist) {
    const std::lock_guard lock(linking_);
    return publishDrive(link_, twist, monotonicNow());
  }

 private:
  template <typename Message>
  void subscribe(const char* channel) {
    link_.subscribe(channel, [this](std::span<const std::uint8_t> data) {
      const auto message = decodeChecked<Message>(data);
      if constexpr (!std::is_same_v<Message, map_meta_t> && !std::is_same_v<Message, map_edit_t>) {
        if (message) foxglove_.take(*message);
      }
      const std::lock_guard lock(shared_.mutex);
      message ? shared_.state.take(*message, monotonicNow()) : shared_.state.countBadMessage();
    });
  }
  /// What Foxglove's clients alone see.
  template <typename Message>
  void subscribeWatched(const char* channel) {
    link_.subscribe(channel, [this](std::span<const std::uint8_t> data) {
      if (!foxglove_.isWatched()) return;
      if (const auto message = decodeChecked<Message>(data)) return foxglove_.take(*message);
      const std::lock_guard lock(shared_.mutex);
      shared_.state.countBadMessage();
    });
  }
  void subscribeTiles(const char* channel, MapLayer layer) {
    link_.subscribe(channel, [this, layer](std::span<const std::uint8_t> data) {
      const auto tile = decodeChecked<map_tile_t>(data);
      const std::lock_guard lock(shared_.mutex);
      tile ? shared_.state.take(layer, *tile, monotonicNow()) : shared_.state.countBadMessage();
    });
  }

  std::mutex linking_;  // of the link: requests send, too
  LcmLink link_;
  SharedState& shared_;
  FoxgloveHub& foxglove_;
};

/// Where slamd keeps its maps or field logs; empty: nowhere.
std::filesystem::path folderOf(const std::string& given, const char* service) {
  std::error_code error;
  return given.empty() && std::filesystem::is_directory(service, error) ? service : given;
}

/// Keeps the last day over the ends of slam-web, where it is the service; a reason why not is printed once. In a thread
/// of its own: whoever waits for a disk must not hold up the end of a drive.
class DayKeeper {
 public:
  explicit DayKeeper(SharedState& shared) : shared_(shared), file_(folder()) {
    attempt([this] {
      auto day = file_.read();
      if (!day) return;
      const std::lock_guard lock(shared_.mutex);
      shared_.state.begin(*std::move(day));
    });
    thread_ = std::thread([this] { run(); });
  }
  ~DayKeeper() {
    {
      const std::lock_guard lock(ending_);
      ends_ = true;
    }
    woken_.notify_one();
    thread_.join();
  }
  DayKeeper(const DayKeeper&) = delete;
  DayKeeper& operator=(const DayKeeper&) = delete;

 private:
  static std::filesystem::path folder() { return std::getenv("STATE_DIRECTORY") != nullptr ? stateFolder() : ""; }
  /// Writes each five minutes, and at the end.
  void run() {
    std::unique_lock lock(ending_);
    for (bool ends = false; !ends;) {
      ends = woken_.wait_for(lock, kKeepPeriod, [this] { return ends_; });
      keep();
    }
  }
  void keep() {
    attempt([this] {
      const DayHistory day = [this] {
        const std::lock_guard lock(shared_.mutex);
        return shared_.state.day();
      }();
      file_.write(day);
    });
  }
  template <typename Step>
  void attempt(const Step& step) {
    try {
      step();
    } catch (const std::runtime_error& error) {
      if (std::exchange(last_error_, error.what()) != error.what()) std::cerr << "slam-web: " << error.what() << "\n";
    }
  }

  SharedState& shared_;
  HistoryFile file_;
  std::string last_error_;
  std::mutex ending_;
  std::condition_variable woken_;
  bool ends_ = false;
  std::thread thread_;
};

int signalDescriptor() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // in all threads that begin after this
  return signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
}

/// Until a signal ends it.
int serve(const Config& config, const std::string& socket, const std::string& logs) {
  const int signals = signalDescriptor();
  std::signal(SIGPIPE, SIG_IGN);
  SharedState shared(config);
  const std::int64_t session = toMicroseconds(monotonicNow() + wallClockOffset());
  const DayKeeper keeper(shared);
  const bool drives = config.base_device.speed_commands;
  EventFeed feed(session, config.web.commands, SLAMD_VERSION,
                 drives ? std::optional(config.base_device.limits) : std::nullopt);
  FoxgloveHub foxglove(shared, config, std::to_string(session));
  Listener listener(config.lcm.url, shared, foxglove);
  DriveRelay relay([&listener](const Twist2& twist) { return listener.drive(twist); });
  const auto drive = [&relay](const DriveRequest& request) { return relay.take(request, monotonicNow()); };
  const auto command = [&config, &socket, &shared](const WebCommand& c) {
    auto ack = Remote(socket, config.lcm.url).ask(c.verb, c.argument, c.pose, kAnswerLimit);
    if (c.verb == "log_mark" && ack && ack->accepted != 0) {
      const std::lock_guard lock(shared.mutex);
      shared.state.mark(c.argument);
    }
    return ack;
  };
  const WebPages pages({config.web, folderOf(config.store.directory, kServiceMaps), folderOf(logs, kServiceLog),
                        SLAMD_VERSION, session, drives, config.map},
                       shared, command, drive);
  EventHub hub;
  TlsContext tls =
      config.web.tls ? tlsContextOf(config.web, stateFolder(), ownNames(config.web.address)) : TlsContext();
  const std::string fingerprint = tls.fingerprint;
  WebServer server(pages, shared, feed, {hub, foxglove}, {}, std::move(tls));
  std::thread http([&server] { server.run(); });
  std::cerr << "slam-web: http" << (config.web.tls ? "s" : "") << "://" << config.web.address << ":" << server.port()
            << "/\n";
  if (config.web.tls) std::cerr << "slam-web: its certificate has the SHA-256 fingerprint " << fingerprint << "\n";

  Timestamp next = monotonicNow();
  for (;;) {
    const Timestamp due = std::min(next, relay.deadline().value_or(next));
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(due - monotonicNow()).count();
    pollfd waiting[] = {{listener.descriptor(), POLLIN, 0}, {signals, POLLIN, 0}};
    ::poll(waiting, 2, static_cast<int>(std::clamp<std::int64_t>(left + 1, 0, 100)));
    if (waiting[1].revents != 0) break;
    listener.receive();
    const Timestamp now = monotonicNow();
    relay.tend(now);
    if (now < next) continue;
    next = now + kEventPeriod;
    std::string news;
    {
      const std::lock_guard lock(shared.mutex);
      news = feed.news(shared.state, now);
    }
    hub.send(news, now);
  }
  relay.end(monotonicNow());  // first: requests may take their time
  server.stop();
  http.join();
  ::close(signals);
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Shows the live map on a page: a program of its own beside slamd, which needs no rights", "slam-web");
  std::string config_file = kServiceConfig, address, logs;
  int port = -1;
  std::vector<std::string> overrides;
  app.add_option("--config", config_file,
                 "slamd's configuration: LCM URL, socket, folder of the logs, section [web], where the lidar sits")
      ->capture_default_str();
  app.add_option("--set", overrides, "section.key=value over the file; may be repeated");
  app.add_option("--address", address, "to listen on, in place of web.address");
  app.add_option("--port", port, "to listen on, in place of web.port; 0: any that is free")
      ->check(CLI::Range(0, 65535));
  app.add_option("--logs", logs, "folder of field logs; in place of log.directory");

  return slam::runProgram(app, argc, argv, SLAMD_VERSION, "slam-web --address 0.0.0.0", [&] {
    const bool given = app.count("--config") > 0 || std::filesystem::exists(config_file);
    auto config = given ? slam::loadConfig(config_file, overrides) : slam::parseConfig("", "defaults", overrides);
    if (!address.empty()) config.web.address = address;
    if (port >= 0) config.web.port = port;
    config.web.token = tokenOf(config.web);
    return serve(config, slam::socketOf(config, config_file), logs.empty() ? config.log.directory : logs);
  });
}
