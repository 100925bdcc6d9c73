// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/report.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "config/loader.hpp"
#include "store/log_folder.hpp"
#include "tools/files.hpp"
#include "tools/unzip.hpp"

namespace slam::report_test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr std::int64_t kSecond = 1'000'000, kStart = 1'764'052'675 * kSecond;  // 2025-11-25 06:37:55
constexpr char kToken[] = "correct horse battery";

class Report : public testing::Test {
 protected:
  static ReportSources sources() {
    return {
        .version = "1.2.3",
        .configuration =
            [] {
              Config config;
              config.web.commands = true;
              config.web.token = kToken;
              config.lidar_device.port = "/dev/lidar";
              return config;
            },
        .doctor =
            [] {
              return Findings{{Finding::kFault, "lidar: not there", "plug it in"}, {Finding::kGood, "clock: set", ""}};
            },
        .status =
            [] {
              return nlohmann::json{{"state", "localised"}};
            },
        .logs = {}};
  }
  /// A log of records a second apart.
  fs::path log(int seconds) const {
    const fs::path run = folder_ / "logs/2025-11-25T06-37-55Z_boot";
    fs::create_directories(run);
    EventLogWriter log(logPath(run, 0));
    const std::uint8_t data[] = {7};
    EXPECT_TRUE(log.write(kStart, channel::kConfig, data));
    for (int i = 0; i <= seconds; ++i) EXPECT_TRUE(log.write(kStart + i * kSecond, channel::kScan, data));
    EXPECT_TRUE(log.flush());
    return folder_ / "logs";
  }

  test::Folder folder_;
  const fs::path out_ = folder_ / "report.zip";
};

TEST_F(Report, HoldsVersionsConfigurationDoctorAndStatus) {
  const auto lines = writeReport(sources(), out_);
  const auto entries = test::unzipped(out_);
  EXPECT_EQ(entries.size(), 4U);
  EXPECT_THAT(entries.at("versions.txt"), HasSubstr("slamctl 1.2.3\nkernel Linux"));
  EXPECT_THAT(entries.at("configuration.toml"), HasSubstr("/dev/lidar"));
  EXPECT_THAT(entries.at("doctor.txt"),
              HasSubstr("FAULT    lidar: not there\n           fix: plug it in\nok       clock"));
  EXPECT_EQ(entries.at("status.json"), "{\"state\":\"localised\"}\n");
  EXPECT_THAT(lines, Contains(HasSubstr("doctor.txt: ")));
  EXPECT_THAT(lines, Contains("no field log"));
}

TEST_F(Report, HasNoSecretInAnyOfItsParts) {
  for (const ReportPart& part : reportParts(sources())) EXPECT_THAT(part.content, Not(HasSubstr(kToken))) << part.name;
  ReportSources wrong = sources();
  wrong.configuration = [] {
    return parseConfig("[web]\ncommands = true\ntoken = \"correct horse battery\"\ntokem = \"correct horse battery\"\n",
                       "a.toml");
  };
  for (const ReportPart& part : reportParts(wrong)) EXPECT_THAT(part.content, Not(HasSubstr(kToken))) << part.name;
}

TEST_F(Report, IsWrittenWhateverIsBroken) {
  ReportSources broken = sources();
  broken.configuration = [] { return parseConfig("[lidar]\nrange_maxx = 3\n", "a.toml"); };
  broken.doctor = []() -> Findings { throw std::runtime_error("no USB"); };
  broken.status = []() -> nlohmann::json { throw std::runtime_error("no answer on /run/slamd/socket"); };
  broken.logs = folder_ / "none";
  const auto lines = writeReport(broken, out_);
  const auto entries = test::unzipped(out_);
  EXPECT_THAT(entries.at("configuration.toml"), HasSubstr("missing: a.toml:2"));
  EXPECT_EQ(entries.at("doctor.txt"), "missing: no USB\n");
  EXPECT_THAT(entries.at("status.json"), HasSubstr("no answer"));
  EXPECT_THAT(entries.at("log.txt"), HasSubstr("none"));
  EXPECT_THAT(lines, Contains("doctor.txt: missing: no USB"));
}

TEST_F(Report, HasTheLastTwoMinutesOfTheLogHoweverOldItIs) {
  ReportSources logged = sources();
  logged.logs = log(300);
  const auto lines = writeReport(logged, out_);
  EXPECT_THAT(lines, Contains(HasSubstr("field log from 2025-11-25 06:40:55 to 2025-11-25 06:42:55")));
  const fs::path log = folder_.write("log.lcm", test::unzipped(out_).at("log.lcm"));
  EventLogReader reader(log);
  int scans = 0, configurations = 0;
  for (LogEvent event; reader.next(event);) ++(event.channel == channel::kConfig ? configurations : scans);
  EXPECT_EQ(scans, 121);
  EXPECT_EQ(configurations, 1);
  EXPECT_FALSE(fs::exists(out_.string() + ".log"));
}

}  // namespace
}  // namespace slam::report_test
