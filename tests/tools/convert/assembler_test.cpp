// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/assembler.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::assembler_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t kNow = 1'700'000'000'000'000;  // [us]

/// One record of each kind.
class OneOfEach : public Reader {
 public:
  OneOfEach() : Reader("in") {}
  void read(Assembler& to) override {
    passes_.push_back(to.surveying());
    scan_->size = 0;
    for (const float range : {1.0F, 2.5F}) scan_->push({.range = range});
    const Origin at{.sensor = "lidar", .where = "in:1", .stamp = kNow, .received = kNow + 5'000};
    to.scan(at, *scan_, {.written = written_});
    to.wheels(at.of("wheels of lidar"), {1.0, 2.0, 0.5});
    to.wheels({.sensor = "wheels", .where = "in:2"}, {});
    to.imu({.where = "in:3", .stamp = kNow, .received = kNow}, {0.0, 0.0, 0.25}, {0.0, 0.0, 9.8});
    to.refuse({.sensor = "wheels", .where = "in:4"}, "cut off");
    for (const char* kind : {"map", "map", "video"}) to.passOver(kind, 1);
  }
  void decide(Assembler& to) override { to.codes = {2.5}; }
  void finish(Assembler& to) override { to.noteChannels(); }

  std::vector<bool> passes_;  // surveying or not

 private:
  std::vector<double> written_{1.0, 2.5};
};

TEST(Assembler, WritesAndCountsInTheSecondPassAlone) {
  const test::Folder folder;
  OneOfEach reader;
  const Recording recording = assemble(std::move(reader), folder / "out.lcm");
  EXPECT_THAT(reader.passes_, ElementsAre(true, false));
  EXPECT_EQ(recording.scans, 1);
  EXPECT_EQ(recording.wheels, 1);
  EXPECT_EQ(recording.imu, 1);
  EXPECT_EQ(recording.rejected, 2);
  EXPECT_EQ(recording.first_rejection, "in:2: its stamp is not a time");
  EXPECT_THAT(recording.unused, ElementsAre(HasSubstr("map, 2 messages")));
  std::vector<std::string> names;
  for (const SensorRows& rows : recording.sensors) names.push_back(rows.name);
  EXPECT_THAT(names, ElementsAre("lidar", "wheels of lidar", "wheels"));
  const test::Log log = test::readLog(folder / "out.lcm");
  EXPECT_THAT(log.event_times, ElementsAre(kNow, kNow + 5'000, kNow + 5'000)) << "in the order of receipt";
  EXPECT_THAT(log.scan_utimes, ElementsAre(kNow));
  EXPECT_TRUE(log.scans[0].isReturn(log.scans[0].beams()[0]));
  EXPECT_FALSE(log.scans[0].isReturn(log.scans[0].beams()[1])) << "a code";
}

}  // namespace
}  // namespace slam::assembler_test
