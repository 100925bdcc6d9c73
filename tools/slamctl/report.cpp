// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/report.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <sys/utsname.h>
#include <thread>

#include "config/printer.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/slamctl/log.hpp"
#include "tools/slamctl/zip_file.hpp"

namespace slam {
namespace {

constexpr std::int64_t kLogged = 120'000'000;  // [us] of the field log

/// Versions of the packages that slamd comes from and that reach its devices.
std::string packages() {
  constexpr std::string_view kWanted[] = {"slamd",        "slamd-tools",    "slamd-spy",    "liblcm1",
                                          "libopenni2-0", "libserialport0", "libusb-1.0-0", "libcpp-httplib0.11"};
  std::ifstream status("/var/lib/dpkg/status");
  std::string text, name;
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("Package:")) name = line.substr(9);
    const bool wanted = std::find(std::begin(kWanted), std::end(kWanted), name) != std::end(kWanted);
    if (wanted && line.starts_with("Version:")) text += name + " " + line.substr(9) + "\n";
  }
  return text;
}

std::string versions(const std::string& slamd) {
  utsname system{};
  uname(&system);
  std::string text = "slamctl " + slamd + "\nkernel " + system.sysname + " " + system.release + " " + system.machine +
                     ", " + std::to_string(std::thread::hardware_concurrency()) + " processors\n";
  std::ifstream release("/etc/os-release");
  for (std::string line; std::getline(release, line);)
    if (line.starts_with("PRETTY_NAME=")) text += "system " + line.substr(12) + "\n";
  return text + packages();
}

std::string textOf(const Findings& findings) {
  constexpr const char* kLevels[] = {"ok       ", "warning  ", "FAULT    "};
  std::string text;
  for (const Finding& finding : findings)
    text += kLevels[finding.level] + finding.what + "\n" +
            (finding.fix.empty() ? "" : "           fix: " + finding.fix + "\n");
  return text;
}

/// The content, or why there is none.
template <typename Make>
ReportPart part(const std::string& name, Make&& make) {
  try {
    return {name, make(), false};
  } catch (const std::exception& error) {
    return {name, std::string("missing: ") + error.what() + "\n", true};
  }
}

/// A file that is removed again.
struct TemporaryFile {
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  std::filesystem::path path;
};

std::string sizeText(std::uintmax_t bytes) {
  return bytes < 100'000 ? std::to_string(bytes) + " bytes" : std::to_string(bytes / 1000) + " kB";
}

}  // namespace

std::string shareableConfiguration(Config config) {
  config.web = {};
  return printConfig(config);
}

std::vector<ReportPart> reportParts(const ReportSources& sources) {
  return {part("versions.txt", [&] { return versions(sources.version); }),
          part("configuration.toml", [&] { return shareableConfiguration(sources.configuration()); }),
          part("doctor.txt", [&] { return textOf(sources.doctor()); }),
          part("status.json", [&] { return textOf(sources.status()) + "\n"; })};
}

std::vector<std::string> writeReport(const ReportSources& sources, const std::filesystem::path& out) {
  ZipFile zip(out);
  std::vector<std::string> lines;
  for (const ReportPart& part : reportParts(sources)) {
    zip.add(part.name, part.content);
    const std::string_view words(part.content);
    lines.push_back(part.name + ": " +
                    (part.missing ? std::string(words.substr(0, words.size() - 1)) : sizeText(words.size())));
  }
  try {
    const auto newest = sources.logs.empty() ? std::nullopt : newestTime(sources.logs);
    if (!newest) {
      lines.push_back("no field log");
    } else {
      const TemporaryFile log{out.string() + ".log"};
      const LogExport done = exportLogs(sources.logs, *newest - kLogged, log.path);
      zip.addFile("log.lcm", log.path);
      lines.push_back("log.lcm: " + sizeText(std::filesystem::file_size(log.path)) + ", field log from " +
                      timeText(done.first) + " to " + timeText(done.last) + " (UTC)");
    }
  } catch (const std::runtime_error& error) {
    zip.add("log.txt", std::string("missing: ") + error.what() + "\n");
    lines.push_back(std::string("no field log: ") + error.what());
  }
  zip.close();
  return lines;
}

}  // namespace slam
