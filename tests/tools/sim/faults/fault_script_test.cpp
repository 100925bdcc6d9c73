// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/fault_script.hpp"

#include <fcntl.h>
#include <fstream>
#include <gmock/gmock.h>
#include <sstream>
#include <unistd.h>

namespace slam::sim::fault_script_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(FaultScript, IsReadInTheOrderOfItsTimes) {
  std::istringstream in(
      "# a plug is pulled\n\n20 lidar unplug 0\n 12.5 lidar unplug   # and put back later\n3 board wrong 0.5\r\n");
  const auto script = readFaultScript(in, "faults.txt");
  ASSERT_EQ(script.size(), 3U);
  EXPECT_EQ(script[0].fault.device, "board");
  EXPECT_EQ(script[0].fault.kind, "wrong");
  EXPECT_EQ(script[0].fault.value, 0.5);
  EXPECT_EQ(script[1].at, fromSeconds(12.5));
  EXPECT_EQ(script[1].fault.value, 1.0) << "a fault without a value is switched on";
  EXPECT_EQ(script[2].fault.value, 0.0);
  EXPECT_EQ(script[2].line, 3);
}

TEST(FaultScript, NamesTheLineThatIsNone) {
  for (const char* bad : {"lidar unplug 1", "5 lidar", "5 radar unplug", "-1 lidar unplug", "5 lidar unplug on",
                          "5 lidar unplug 1 2", "nan lidar unplug", "5 lidar unplug 1x"}) {
    std::istringstream in("1 board silent\n" + std::string(bad) + "\n");
    try {
      readFaultScript(in, "faults.txt");
      ADD_FAILURE() << bad;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("faults.txt:2: ")) << bad;
    }
  }
}

class FaultPipeTest : public testing::Test {
 protected:
  void write(const std::string& text) {
    const int descriptor = open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(descriptor, 0);
    EXPECT_EQ(::write(descriptor, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    close(descriptor);
  }
  const fs::path path_ = fs::path(testing::TempDir()) / ("faults_" + std::to_string(getpid()));
};

TEST_F(FaultPipeTest, GivesWholeLinesOfOneWriterAfterTheOther) {
  FaultPipe pipe(path_);
  EXPECT_THAT(pipe.read(), ElementsAre());
  write("lidar unplug 1\nboard si");
  EXPECT_THAT(pipe.read(), ElementsAre("lidar unplug 1"));
  write("lent 1\n");
  EXPECT_THAT(pipe.read(), ElementsAre("board silent 1"));
}

TEST_F(FaultPipeTest, ForgetsALineWithoutEnd) {
  FaultPipe pipe(path_);
  for (int i = 0; i < 10; ++i) {
    write(std::string(400, 'x'));
    EXPECT_THAT(pipe.read(), ElementsAre());
  }
  write("\nlidar unplug 1\n");
  EXPECT_THAT(pipe.read(), testing::Contains("lidar unplug 1"));
}

TEST_F(FaultPipeTest, LeavesNothingBehind) {
  { const FaultPipe pipe(path_); }
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_THROW(FaultPipe("/proc/faults"), std::system_error);
}

TEST_F(FaultPipeTest, AndAScriptFillAQueueFromWhichEachDeviceTakesItsOwn) {
  const fs::path script = path_.string() + ".txt";
  std::ofstream(script) << "1 lidar unplug\n2 lidar silent\n2 board silent\n";
  FaultQueue queue(script, path_);
  std::vector<std::string> taken;
  const auto deliver = [&](std::string_view device) {
    taken.clear();
    queue.deliver(device, [&](const Fault& fault) { return taken.push_back(fault.kind), true; });
    return taken;
  };
  EXPECT_THAT(deliver("lidar"), ElementsAre()) << "nothing is due";
  queue.collect(fromSeconds(1.5));
  write("lidar stuck 1\nno fault at all\n");
  queue.collect(fromSeconds(2.0));
  EXPECT_THAT(deliver("lidar"), ElementsAre("unplug", "silent", "stuck"));
  EXPECT_THAT(deliver("lidar"), ElementsAre()) << "each is delivered once";
  EXPECT_THAT(deliver("board"), ElementsAre("silent"));
  fs::remove(script);
  EXPECT_THROW(FaultQueue(script, path_), std::runtime_error);
}

}  // namespace
}  // namespace slam::sim::fault_script_test
