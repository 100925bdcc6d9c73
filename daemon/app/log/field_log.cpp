// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/field_log.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <slam/config_t.hpp>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "app/log/log.hpp"
#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "config/printer.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
constexpr Duration kSyncPeriod = 2s;  // and the recorder's tenth of a second: so much is lost when the power is cut
constexpr Duration kLookPeriod = 1s;
constexpr Duration kBeforeMark = 60s;  // what a mark is about may be this old
constexpr std::size_t kMostWords = 500;
constexpr double kMegabyte = 1e6;
constexpr int kLeastPriority = 19;

LogLimits limitsOf(const LogConfig& config) {
  return {.quota = static_cast<std::uint64_t>(config.quota * kMegabyte),
          .floor = static_cast<std::uint64_t>(config.floor * kMegabyte),
          .file_length = fromSeconds(config.file_length)};
}

struct NoRoom : std::runtime_error {
  NoRoom() : std::runtime_error("no room") {}
};

/// The unit gives it where /proc/sys is not to be seen.
std::string readBootId() {
  const char* given = std::getenv("SLAMD_BOOT_ID");
  std::string text = given != nullptr ? given : "";
  if (text.empty()) std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), text);
  std::erase_if(text, [](unsigned char c) { return std::isxdigit(c) == 0; });
  return text;
}

std::string versions() {
  utsname system{};
  if (::uname(&system) != 0) return "slamd " SLAMD_VERSION;
  return std::string("slamd " SLAMD_VERSION ", ") + system.sysname + " " + system.release + " " + system.machine;
}

std::string hostName() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string megabytes(std::uint64_t bytes) {
  const double number = static_cast<double>(bytes) / kMegabyte;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), number < 10.0 ? "%.1f MB" : "%.0f MB", number);
  return text.data();
}

/// Makes a folder that was not there.
fs::path makeRun(const fs::path& folder, const std::string& name) {
  // A clock that was set back, or a second start within one second, gives a name that is used.
  for (int copy = 1;; ++copy) {
    const fs::path run = folder / (copy == 1 ? name : name + "-" + std::to_string(copy));
    if (fs::create_directory(run)) return run;
  }
}

/// What a log is replayed with. Logs are handed to others: the web page's token is nothing for them.
std::string configurationFor(Config config) {
  config.web = {};
  return printConfig(config);
}

}  // namespace

FieldLog::FieldLog(const Config& config, const WallClock& clock, std::function<void()> wake)
    : config_(config.log),
      limits_(limitsOf(config.log)),
      clock_(clock),
      wake_(std::move(wake)),
      boot_id_(readBootId()),
      configuration_(configurationFor(config)),
      running_(config.log.automatic) {}

FieldLog::~FieldLog() { ending_ = true; }

bool FieldLog::takes(std::string_view channel) const {
  if (!running_) return false;
  return config_.content == LogContent::kAll || channel == channel::kScan || channel == channel::kWheels ||
         channel == channel::kImu || channel == channel::kDepth;
}

void FieldLog::tend() {
  commands_.drain([this](const LogCommand& command) { obey(command); });
}

void FieldLog::obey(const LogCommand& command) {
  MapAnswer answer{.id = command.id, .accepted = true, .message = ""};
  switch (command.kind) {
    case LogCommand::kStart:
      answer.message = running_.exchange(true) ? "it is being logged already, into " + config_.directory
                                               : "logging into " + config_.directory;
      break;
    case LogCommand::kStop:
      answer.message = running_.exchange(false) ? "logging stopped" : "nothing was being logged";
      break;
    case LogCommand::kMark:
      try {
        answer.message = mark(command.what);
      } catch (const std::exception& error) {
        answer.accepted = false;
        answer.message = std::string("not marked: ") + error.what();
      }
  }
  answers_.tryPush(answer);
  wake_();
}

std::string FieldLog::mark(const std::string& what) {
  if (!running_)
    throw std::runtime_error(
        "nothing is being logged: the log is stopped; begin it with slamctl log start, and mark again");
  if (!file_ && why_not_) throw std::runtime_error(why_not_.words());
  if (!file_) throw std::runtime_error("nothing has come yet that could be logged; mark again in a second");
  const Timestamp now = monotonicNow();
  std::string line = what.substr(0, kMostWords);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  line = utcName(clock_.utime(now)) + " " + line + "\n";
  const auto keep_last = [&](std::int64_t number) {
    AppendFile words(markPath(run_, number), AppendFile::kAll);
    words.append(line);
    words.sync();
  };
  file_->sync();
  keep_last(number_);
  const bool before = now - begun_ < kBeforeMark && (fs::exists(logPath(run_, number_ - 1)) ||
                                                     fs::exists(logPath(run_, number_ - 1).string() + ".gz"));
  if (before) keep_last(number_ - 1);
  syncFolder(run_);
  return "marked " + file_->path().string();
}

void FieldLog::write(std::string_view records, std::int64_t utime) {
  const Timestamp now = monotonicNow();
  if (file_ && !file_->isThere()) drop();
  try {
    if (!running_) {
      if (file_ && !records.empty()) file_->append(records);  // what came before the stop
      return close();
    }
    prepare(now);
    checkRoom(now);
    if (file_ && file_->size() > synced_size_ && now - synced_ >= kSyncPeriod) {
      file_->sync();
      synced_ = now;
      synced_size_ = file_->size();
    }
    if (records.empty()) return;
    if (file_ && isFull(now - begun_, file_->size() + image_bytes_, limits_)) close();
    file_ ? file_->append(records) : begin(records, utime, now);
    why_not_ = {};
  } catch (const std::exception& error) {
    why_not_ = problemOf(error);
    drop();  // the next one may be on another disk
    throw;
  }
}

void FieldLog::prepare(Timestamp now) {
  if (lock_ && !lock_->isThere()) {
    lock_.reset();
    run_.clear();
  }
  if (!lock_) {
    fs::create_directories(config_.directory);
    lock_.emplace(config_.directory);
    number_ = nextNumber(logFilesIn(config_.directory)) - 1;
  }
  if (run_.empty() || !fs::is_directory(run_)) {
    run_ = makeRun(config_.directory, runName(clock_.utime(now), boot_id_));
    syncFolder(config_.directory);
  }
}

void FieldLog::checkRoom(Timestamp now) {
  if (now - looked_ >= kLookPeriod) {
    looked_ = now;
    if (!keeper_.isBusy()) keeper_.start([this, run = run_, end = number_ + (file_ ? 0 : 1)] { keep(run, end); });
    free_ = fs::space(config_.directory).available;
    image_bytes_ = 0;
    for (const LogFile& file : config_.images&& file_ ? logFilesIn(run_) : std::vector<LogFile>{}) {
      if (!file.isLog() && file.number == number_) image_bytes_ += file.bytes;
    }
    has_room_ = hasRoom(free_, limits_.floor, has_room_);
  }
  if (has_room_) return;
  close();
  throw NoRoom();
}

void FieldLog::begin(std::string_view records, std::int64_t utime, Timestamp now) {
  // Somebody may have put further files there.
  number_ = std::max(number_ + 1, nextNumber(logFilesIn(config_.directory)));
  const fs::path path = logPath(run_, number_);
  AppendFile& file = file_.emplace(path, AppendFile::kNew);
  try {
    file.append(header(utime) + std::string(records));
    file.sync();
    syncFolder(run_);
  } catch (const std::exception&) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
  begun_ = synced_ = now;
  synced_size_ = file.size();
  image_bytes_ = 0;
  if (config_.images) images_.set(fs::path(path).replace_extension(".oni"));
}

void FieldLog::drop() {
  file_.reset();
  images_.set("");
}

void FieldLog::close() {
  if (!file_) return;
  const bool early =
      file_->size() + image_bytes_ >= limits_.fileBytes() && monotonicNow() - begun_ < limits_.file_length;
  if (early && !std::exchange(short_logged_, true)) {
    logWarning("log: a file of log.file_length is larger than an eighth of log.quota; files end at " +
               megabytes(limits_.fileBytes()) + "; raise log.quota for longer ones");
  }
  file_->sync();
  drop();
}

std::string FieldLog::header(std::int64_t utime) const {
  config_t message{};
  message.utime = utime;
  message.host = hostName();
  message.boot_id = boot_id_;
  message.map_id = map_id_;
  message.versions = versions();
  message.configuration = configuration_;
  std::vector<std::uint8_t> data(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(data.data(), 0, static_cast<int>(data.size()));
  std::string record;
  appendRecord(record, 0, utime, channel::kConfig, data);
  return record;
}

void FieldLog::finish() { close(); }

bool FieldLog::keeperHangs(Timestamp deadline) {
  ending_ = true;
  return !keeper_.waitUntilIdle(deadline);
}

Problem FieldLog::problemOf(const std::exception& error) const {
  if (dynamic_cast<const NoRoom*>(&error) == nullptr) return {problem::kLogNotWritten, {}, {"", "", error.what()}};
  return {problem::kLogNoRoom,
          {1e-6 * static_cast<double>(free_), 1e-6 * static_cast<double>(limits_.floor)},
          {config_.directory}};
}

void FieldLog::keep(const fs::path& run, std::int64_t end) {
  if (!std::exchange(lowered_, true)) ::setpriority(PRIO_PROCESS, 0, kLeastPriority);  // of this thread alone
  try {
    tidyLogs(config_.directory, run);
    std::vector<LogFile> files = logFilesIn(config_.directory);
    std::erase_if(files, [&](const LogFile& file) { return file.number >= end; });
    const auto gone = filesToRemove(files, fs::space(config_.directory).available, limits_);
    for (const std::size_t i : gone) removeLog(files[i]);
    for (std::size_t i = 0; i < files.size() && !ending_; ++i) {
      const bool removed = std::find(gone.begin(), gone.end(), i) != gone.end();
      if (removed || files[i].path.extension() != ".lcm") continue;
      // While it is compressed, it is there twice.
      if (fs::space(config_.directory).available < limits_.floor / 2 + files[i].bytes) break;
      compressLog(files[i].path, ending_);
      break;  // and see again what is there
    }
    logLines(keeper_log_.look({}, monotonicNow()));
  } catch (const std::exception& error) {
    const Trouble fails{.device = "log",
                        .problem = {problem::kDiskFails, {}, {config_.directory, "", error.what()}},
                        .begin = "log: ",
                        .meanwhile = "older logs stay as they are",
                        .recovery = "log: older logs are tidied up again"};
    logLines(keeper_log_.look({fails}, monotonicNow()));
  }
}

}  // namespace slam
