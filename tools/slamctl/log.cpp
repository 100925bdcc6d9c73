// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/log.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <sys/stat.h>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "store/log_folder.hpp"
#include "store/log_policy.hpp"
#include "tools/common/output_file.hpp"

namespace slam {
namespace {

constexpr std::int64_t kSecond = 1'000'000;  // [us]

std::optional<std::int64_t> ago(const std::string& text) {
  double count = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc{} || !(count >= 0.0 && count < 1e9)) return std::nullopt;
  const std::string unit(end, text.data() + text.size());
  for (const auto& [name, seconds] : {std::pair("s", 1.0), {"min", 60.0}, {"h", 3600.0}, {"d", 86400.0}}) {
    if (unit == name) return static_cast<std::int64_t>(count * seconds * static_cast<double>(kSecond));
  }
  return std::nullopt;
}

/// [us] of the first record; std::nullopt: there is none.
std::optional<std::int64_t> firstTime(const LogFile& file) {
  try {
    EventLogReader reader(file.path);
    LogEvent event;
    return reader.next(event) ? std::optional(event.utime) : std::nullopt;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// [us since the epoch] when it was written last; 0: it is gone.
std::int64_t modifiedTime(const std::filesystem::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 ? status.st_mtim.tv_sec * kSecond + status.st_mtim.tv_nsec / 1000 : 0;
}

std::vector<LogFile> logsIn(const std::filesystem::path& folder) {
  std::vector<LogFile> files = logFilesIn(folder);
  std::erase_if(files, [](const LogFile& file) { return !file.isLog(); });
  return files;
}

std::vector<std::string> marksOf(const LogFile& file) {
  std::vector<std::string> marks;
  const std::string words = markOf(file);
  for (std::size_t at = 0, end = 0; (end = words.find('\n', at)) != std::string::npos; at = end + 1)
    marks.push_back(words.substr(at, end - at));
  return marks;
}

}  // namespace

nlohmann::json logsJson(const std::filesystem::path& folder) {
  auto list = nlohmann::json::array();
  for (const LogFile& file : logFilesIn(folder)) {
    const auto first = file.isLog() ? firstTime(file) : std::nullopt;
    list.push_back({{"run", file.run()},
                    {"file", file.path.filename().string()},
                    {"bytes", file.bytes},
                    {"utime", first ? nlohmann::json(*first) : nlohmann::json()},
                    {"modified", modifiedTime(file.path)},
                    {"marks", marksOf(file)}});
  }
  return list;
}

void printLogs(const std::filesystem::path& folder) {
  std::string run;
  double sum = 0.0;
  const std::vector<LogFile> files = logFilesIn(folder);
  for (const LogFile& file : files) {
    if (std::exchange(run, file.run()) != file.run()) std::printf("%s\n", file.run().c_str());
    const double megabytes = 1e-6 * static_cast<double>(file.bytes);
    sum += megabytes;
    const auto first = file.isLog() ? firstTime(file) : std::nullopt;
    std::printf("  %-14s %9.1f MB  %s\n", file.path.filename().c_str(), megabytes,
                first          ? utcName(*first).c_str()
                : file.isLog() ? "no whole record in it"
                               : "images");
    for (const std::string& mark : marksOf(file)) std::printf("    marked %s\n", mark.c_str());
  }
  std::printf("%zu file%s in %s, %.1f MB\n", files.size(), files.size() == 1 ? "" : "s", folder.c_str(), sum);
}

std::int64_t sinceTime(const std::string& text, std::int64_t now) {
  if (const auto before = ago(text)) return now - *before;
  for (const char* format : {"%Y-%m-%dT%H:%M:%SZ", "%Y-%m-%dT%H:%M:%S", "%Y-%m-%dT%H-%M-%SZ", "%Y-%m-%d %H:%M:%S",
                             "%Y-%m-%d %H:%M", "%Y-%m-%dT%H:%M", "%Y-%m-%d"}) {
    std::tm utc{};
    const char* end = strptime(text.c_str(), format, &utc);
    if (end != nullptr && *end == '\0') return static_cast<std::int64_t>(timegm(&utc)) * kSecond;
  }
  throw std::runtime_error("\"" + text + "\" is no time; write 90s, 10min, 2h, 3d, or a UTC time such as " +
                           "\"2026-11-25 06:37\"");
}

std::string timeText(std::int64_t utime) {
  const auto seconds = static_cast<std::time_t>(utime / 1000000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &utc);
  return utime == 0 ? "-" : text;
}

std::optional<std::int64_t> newestTime(const std::filesystem::path& folder) {
  const std::vector<LogFile> files = logsIn(folder);
  for (auto file = files.rbegin(); file != files.rend(); ++file) {
    std::optional<std::int64_t> newest;
    try {
      EventLogReader reader(file->path);
      for (LogEvent event; reader.next(event);) {
        if (event.channel != channel::kConfig) newest = std::max(event.utime, newest.value_or(event.utime));
      }
    } catch (const EmptyLog&) {
    }
    if (newest) return newest;
  }
  return std::nullopt;
}

LogExport exportLogs(const std::filesystem::path& folder, std::optional<std::int64_t> since,
                     const std::filesystem::path& out) {
  if (std::filesystem::exists(out)) throw std::runtime_error(out.string() + ": is there already; give another --out");
  prepareOutput(out);
  const std::vector<LogFile> files = logsIn(folder);
  if (files.empty()) throw std::runtime_error(folder.string() + ": no log in this folder");
  LogExport done;
  std::optional<EventLogWriter> writer;
  std::int64_t newest = 0;
  const auto write = [&](const LogEvent& event) {
    if (!writer) writer.emplace(out);
    if (!writer->write(event.utime, event.channel, event.data))
      throw std::runtime_error(out.string() + ": cannot write all of it: is the disk full?");
  };
  for (std::size_t i = 0; i < files.size(); ++i) {
    // What ends before is not read. Between runs the clock may have been set, within one it may not.
    if (since && i + 1 < files.size() && files[i + 1].run() == files[i].run()) {
      if (const auto next = firstTime(files[i + 1]); next && *next < *since) continue;
    }
    std::optional<EventLogReader> reader;
    try {
      reader.emplace(files[i].path);
    } catch (const EmptyLog&) {
      continue;
    }
    bool used = false;
    std::optional<LogEvent> config;
    for (LogEvent event; reader->next(event);) {
      if (event.channel == channel::kConfig) {
        config = event;
        continue;
      }
      newest = std::max(newest, event.utime);
      if (since && event.utime < *since) continue;
      if (config) write({event.utime, config->channel, config->data});
      config.reset();
      write(event);
      if (done.records++ == 0) done.first = event.utime;
      done.last = event.utime;
      used = true;
    }
    done.files += used ? 1 : 0;
  }
  if (!writer) throw std::runtime_error("no record since then; the newest is of " + utcName(newest) + " (UTC)");
  if (!writer->flush()) throw std::runtime_error(out.string() + ": cannot write all of it: is the disk full?");
  return done;
}

}  // namespace slam
