// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "mapping/map_image.hpp"
#include "tools/slamctl/remote.hpp"
#include "tools/web/access/host_guard.hpp"
#include "tools/web/access/token_gate.hpp"
#include "tools/web/drive/drive_answer.hpp"
#include "tools/web/http_library.hpp"
#include "tools/web/logs/log_folder.hpp"
#include "tools/web/maps/map_pictures.hpp"
#include "tools/web/request_guard.hpp"
#include "tools/web/stored_list.hpp"
#include "tools/web/text/metrics_text.hpp"
#include "tools/web/web_state.hpp"

namespace slam {

/// The state, and the lock that belongs to it.
struct SharedState {
  explicit SharedState(const Config& config) : state(config) {}
  mutable std::mutex mutex;
  WebState state;
  FoxgloveCounts foxglove;  ///< needs no lock
};

/// Has slamd do something. @return nothing where no answer came @throws std::runtime_error where nothing was sent
using Commander = std::function<std::optional<Acknowledged>(const WebCommand& command)>;

/// The answers to requests, without sockets. Safe from several threads.
class WebPages {
 public:
  struct Settings {
    WebConfig web;
    std::filesystem::path maps, logs;  ///< folders; empty: none
    std::string version;
    std::int64_t session = 0;  ///< another number for each start of the program
    bool drives = false;       ///< base.speed_commands
    OccupancyGridConfig grid = {};
  };
  static constexpr std::string_view kApi = "/api/v1/";
  static constexpr const char *kEvents = "/api/v1/events", *kCommand = "/api/v1/command", *kDrive = "/api/v1/drive";

  WebPages(Settings settings, const SharedState& shared, Commander commander, Driver driver = nullptr);

  /// As of HostGuard.
  bool mayEnter(const httplib::Request& request, httplib::Response& response) const {
    return hosts_.mayEnter(request, response);
  }
  /// Whether this is for anybody: the page itself, which asks for the token, or for who has the token where one is
  /// needed.
  /// @return false, with the refusal in `response`
  bool mayRead(const httplib::Request& request, httplib::Response& response) const;
  /// The same for Foxglove's connection, with the answer to its handshake. Programs that know an address alone send the
  /// token in it: ws://robot:8080/?token=TOKEN.
  bool mayStream(const httplib::Request& request, httplib::Response& response) const;
  /// All but the stream of events, commands and speeds.
  void answer(const httplib::Request& request, httplib::Response& response) const;
  /// @param request with its body
  void command(const httplib::Request& request, httplib::Response& response) const;
  void drive(const httplib::Request& request, httplib::Response& response) const;

  const Settings& settings() const { return settings_; }
  /// The path with its version, which those of before there were versions lack: /api/status is /api/v1/status.
  static std::string apiPathOf(const std::string& path);
  /// Headers of every answer.
  static httplib::Headers headers();

 private:
  bool mayChange(const httplib::Request& request, httplib::Response& response) const;
  void list(const StoredList& stored, const char* otherwise, httplib::Response& response) const;
  void status(httplib::Response& response) const;
  void history(httplib::Response& response) const;
  void metrics(httplib::Response& response) const;
  void tiles(const httplib::Request& request, httplib::Response& response) const;
  void mapPicture(const std::string& name, httplib::Response& response) const;
  void mapFile(const std::string& path, httplib::Response& response) const;
  void logs(const std::string& path, httplib::Response& response) const;
  void logArchive(httplib::Response& response) const;
  struct Picture {
    MapImage map;
    std::string png;
  };
  /// @return nullptr for a map too large to draw
  std::shared_ptr<const Picture> picture() const;

  Settings settings_;
  const SharedState& shared_;
  const HostGuard hosts_;
  const TokenGate gate_;
  Commander commander_;
  Driver driver_;
  StoredList maps_, logs_;
  MapPictures pictures_;
  mutable std::mutex drawing_;                      // of the two below
  mutable std::shared_ptr<const Picture> picture_;  // kept for a while: .yaml and .pgm belong together
  mutable Timestamp drawn_{};
  mutable std::mutex commanding_;  // one command at a time
};

}  // namespace slam
