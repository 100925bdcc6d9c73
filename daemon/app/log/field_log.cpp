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
#include "problems/answers.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
constexpr Duration kSyncPeriod = 2s;  // and the recorder's tenth of a second: so much is lost when the power is cut
constexpr Duration kLookPeriod = 1s;
constexpr Duration kBeforeMark = 600s;  // what a mark is about may be this old
constexpr std::size_t kMostWords = 500;
constexpr double kMegabyte = 1e6;
constexpr int kLeastPriority = 19;

/// @param log a closed file, which may be compressed by now
bool wasWrittenSince(const fs::path& log, Duration age) {
  std::error_code error;
  auto written = fs::last_write_time(log, error);
  if (error) written = fs::last_write_time(log.string() + ".gz", error);
  return !error && fs::file_time_type::clock::now() - written < age;
}

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

LogHeader::LogHeader(const Config& config) : boot_id_(readBootId()), configuration_(configurationFor(config)) {}

std::string LogHeader::record(std::int64_t utime) const {
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

bool LogKeeper::hangs(Timestamp deadline) {
  ending_ = true;
  return !thread_.waitUntilIdle(deadline);
}

void LogKeeper::keep(const fs::path& run, std::int64_t end) {
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
    logLines(log_.look({}, monotonicNow()));
  } catch (const std::exception& error) {
    const Trouble fails{.device = "log",
                        .problem = {problem::kDiskFails, {}, {config_.directory, "", error.what()}},
                        .begin = "log: ",
                        .meanwhile = "older logs stay as they are",
                        .recovery = "log: older logs are tidied up again"};
    logLines(log_.look({fails}, monotonicNow()));
  }
}

FieldLog::FieldLog(const Config& config, const WallClock& clock, std::function<void()> wake)
    : config_(config.log),
      limits_(limitsOf(config.log)),
      clock_(clock),
      header_(config),
      commands_{.wake = std::move(wake)},
      running_(config.log.automatic),
      keeper_(config_, limits_) {}

bool FieldLog::takes(std::string_view channel) const {
  if (!running_) return false;
  return config_.content == LogContent::kAll || channel == channel::kScan || channel == channel::kWheels ||
         channel == channel::kImu || channel == channel::kDepth;
}

void FieldLog::tend() {
  commands_.asked.drain([this](const LogCommand& command) { obey(command); });
}

void FieldLog::obey(const LogCommand& command) {
  const auto answer = [&](bool accepted, const Answer& given) {
    commands_.answers.tryPush({command.id, accepted, given});
  };
  const auto done = [&](const ProblemKind& kind) { answer(true, answerOf({{kind, {}, {config_.directory}}})); };
  switch (command.kind) {
    case LogCommand::kStart:
      done(running_.exchange(true) ? answer::kLoggingAlready : answer::kLogging);
      break;
    case LogCommand::kStop:
      done(running_.exchange(false) ? answer::kLogStopped : answer::kLogWasStopped);
      break;
    case LogCommand::kMark:
      try {
        answer(true, answerOf({{answer::kMarked, {}, {mark(command.what)}}}));
      } catch (const std::exception& error) {
        answer(false, answerOf(error, answer::kNotMarked));
      }
  }
  commands_.wake();
}

std::string FieldLog::mark(const std::string& what) {
  if (!running_) throw CommandRefused(answer::kMarkStopped);
  if (!open_ && why_not_) throw CommandRefused(why_not_);
  if (!open_) throw CommandRefused(answer::kMarkEmpty);
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
  open_->file.sync();
  keep_last(number_);
  // Files end by size, too: as many before it as were written since.
  for (std::int64_t number = number_ - 1; number >= 0 && wasWrittenSince(logPath(run_, number), kBeforeMark); --number)
    keep_last(number);
  syncFolder(run_);
  return open_->file.path().string();
}

void FieldLog::write(std::string_view records, std::int64_t utime) {
  const Timestamp now = monotonicNow();
  if (open_ && !open_->file.isThere()) drop();
  try {
    if (!running_) {
      if (open_ && !records.empty()) open_->file.append(records);  // what came before the stop
      return close();
    }
    prepare(now);
    checkRoom(now);
    if (open_ && open_->file.size() > open_->synced_size && now - open_->synced >= kSyncPeriod) {
      open_->file.sync();
      open_->synced = now;
      open_->synced_size = open_->file.size();
    }
    if (records.empty()) return;
    if (open_ && isFull(now - open_->begun, open_->file.size() + open_->image_bytes, limits_)) close();
    open_ ? open_->file.append(records) : begin(records, utime, now);
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
    run_ = makeRun(config_.directory, runName(clock_.utime(now), header_.bootId()));
    syncFolder(config_.directory);
  }
}

void FieldLog::checkRoom(Timestamp now) {
  if (now - room_.looked >= kLookPeriod) {
    room_.looked = now;
    if (!keeper_.isBusy()) keeper_.start(run_, number_ + (open_ ? 0 : 1));
    room_.free = fs::space(config_.directory).available;
    if (open_) open_->image_bytes = 0;
    for (const LogFile& file : config_.images&& open_ ? logFilesIn(run_) : std::vector<LogFile>{}) {
      if (!file.isLog() && file.number == number_) open_->image_bytes += file.bytes;
    }
    room_.enough = hasRoom(room_.free, limits_.floor, room_.enough);
  }
  if (room_.enough) return;
  close();
  throw NoRoom();
}

void FieldLog::begin(std::string_view records, std::int64_t utime, Timestamp now) {
  // Somebody may have put further files there.
  number_ = std::max(number_ + 1, nextNumber(logFilesIn(config_.directory)));
  const fs::path path = logPath(run_, number_);
  AppendFile& file = open_.emplace(path, now).file;
  try {
    file.append(header_.record(utime) + std::string(records));
    file.sync();
    syncFolder(run_);
  } catch (const std::exception&) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
  open_->synced_size = file.size();
  if (config_.images) images_.set(fs::path(path).replace_extension(".oni"));
}

void FieldLog::drop() {
  open_.reset();
  images_.set("");
}

void FieldLog::close() {
  if (!open_) return;
  const bool early = open_->file.size() + open_->image_bytes >= limits_.fileBytes() &&
                     monotonicNow() - open_->begun < limits_.file_length;
  if (early && !std::exchange(short_logged_, true)) {
    logWarning("log: a file of log.file_length is larger than an eighth of log.quota; files end at " +
               megabytes(limits_.fileBytes()) + "; raise log.quota for longer ones");
  }
  open_->file.sync();
  drop();
}

void FieldLog::finish() { close(); }

Problem FieldLog::problemOf(const std::exception& error) const {
  if (dynamic_cast<const NoRoom*>(&error) == nullptr) return {problem::kLogNotWritten, {}, {"", "", error.what()}};
  return {problem::kLogNoRoom,
          {1e-6 * static_cast<double>(room_.free), 1e-6 * static_cast<double>(limits_.floor)},
          {config_.directory}};
}

}  // namespace slam
