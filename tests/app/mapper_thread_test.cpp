// SPDX-License-Identifier: BSD-3-Clause
#include "app/mapper_thread.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::waitUntil;
using testing::HasSubstr;

class MapFiles : public testing::Test {
 protected:
  std::string problemOf(const MapperThread& mapper) { return mapper.storage(monotonicNow()).problem; }

  const test::Folder folder;
  Config config;
  WallClock clock;
  Exchange exchange;
};

TEST_F(MapFiles, AreWrittenWhereTheirFolderCanBeMade) {
  config.output.map = folder / "a/b/map";
  MapperThread mapper(config, exchange, clock);
  mapper.finish();
  EXPECT_TRUE(mapper.waitUntilSaved(monotonicNow() + 20s));
  EXPECT_TRUE(fs::exists(folder / "a/b/map.yaml"));
  EXPECT_EQ(problemOf(mapper), "");
}

TEST_F(MapFiles, AreReportedAsSoonAsTheirFolderIsOfNoUse) {
  folder.write("disk", "not mounted yet");
  config.output.map = folder / "disk/map";
  MapperThread mapper(config, exchange, clock);
  mapper.worker().start();
  ASSERT_TRUE(waitUntil([&] { return !problemOf(mapper).empty(); }));
  EXPECT_THAT(problemOf(mapper), testing::AllOf(HasSubstr("disk"), HasSubstr("output.map")));
  exchange.save_map = true;
  ASSERT_TRUE(waitUntil([&] { return exchange.map_saved == SaveOutcome::kFailed; }));
  fs::remove(folder / "disk");
  ASSERT_TRUE(waitUntil([&] { return problemOf(mapper).empty(); })) << problemOf(mapper);
  mapper.worker().stop();
  mapper.finish();
  EXPECT_TRUE(mapper.waitUntilSaved(monotonicNow() + 20s));
  EXPECT_TRUE(fs::exists(folder / "disk/map.png"));
}

TEST_F(MapFiles, KeepNobodyWaitingForADiskThatHangs) {
  config.output.map = folder / "map";
  ASSERT_EQ(mkfifo((folder / "map.pgm.new").c_str(), 0600), 0);  // whoever opens it to write waits
  MapperThread mapper(config, exchange, clock);
  mapper.worker().start();
  exchange.save_map = true;
  ASSERT_TRUE(waitUntil([&] { return mapper.storage(monotonicNow()).waiting > 200ms; }));
  const std::uint64_t ticks = mapper.worker().ticks();
  EXPECT_TRUE(waitUntil([&] { return mapper.worker().ticks() > ticks + 5; }));
  EXPECT_EQ(exchange.map_saved, SaveOutcome::kNone);
  std::ifstream disk(folder / "map.pgm.new", std::ios::binary);  // it answers
  std::string all(std::istreambuf_iterator<char>(disk), {});
  EXPECT_TRUE(waitUntil([&] { return exchange.map_saved == SaveOutcome::kSaved; }));
}

}  // namespace
}  // namespace slam
