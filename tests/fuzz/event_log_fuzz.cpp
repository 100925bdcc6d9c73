// SPDX-License-Identifier: BSD-3-Clause
// The input is the beginning of an LCM log that whole records follow.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "bus/event_log.hpp"
#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"

namespace slam {
namespace {

constexpr std::size_t kHeader = 28;  // [bytes] of a record, before channel and data
constexpr int kGoodRecords = 3;

std::string goodRecord() {
  const std::string channel = "SLAM_IMU", data = "some data";
  std::string record("\xED\xA1\xDA\x01", 4);
  const auto put = [&](std::uint64_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) record += static_cast<char>(value >> 8 * i);
  };
  put(7, 8);
  put(1'000'000, 8);
  put(channel.size(), 4);
  put(data.size(), 4);
  return record + channel + data;
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static const std::string good = goodRecord();
  static const fuzz::MemoryFile file;
  std::string content(reinterpret_cast<const char*>(data), size);
  for (int i = 0; i < kGoodRecords; ++i) content += good;
  const bool compressed = size >= 2 && data[0] == 0x1F && data[1] == 0x8B;
  file.write(content);

  std::uint64_t used = 0;
  int delivered = 0;
  bool swallowed = false;
  try {
    EventLogReader reader(file.path());
    for (LogEvent event; reader.next(event);) {
      FUZZ_CHECK(!event.channel.empty() && event.channel.size() < 64);
      used += kHeader + event.channel.size() + event.data.size();
      const bool is_good =
          event.channel == "SLAM_IMU" && std::equal(event.data.begin(), event.data.end(), good.end() - 9, good.end());
      delivered += is_good ? 1 : 0;
      // A damaged length may reach to the beginning of a good record, which is then part of the one before.
      swallowed |=
          std::search(event.data.begin(), event.data.end(), good.begin() + 4, good.end(),
                      [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); }) != event.data.end();
    }
    if (compressed) return 0;
    FUZZ_CHECK(used + reader.skippedBytes() == content.size());
    FUZZ_CHECK(delivered >= kGoodRecords || swallowed);
  } catch (const std::runtime_error&) {
    FUZZ_CHECK(compressed);  // else there is a record in it
  }
  return 0;
}
