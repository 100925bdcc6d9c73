// SPDX-License-Identifier: BSD-3-Clause
// The input is an LCM log of a Maebot or MBot; the second time its pieces are payloads of sound records.
#include <array>
#include <stdexcept>
#include <string>

#include "bus/event_log.hpp"
#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/read_log.hpp"
#include "tools/convert/formats.hpp"

namespace {

void convert(const std::string& content) {
  using namespace slam;
  static const fuzz::MemoryFile in, out;
  in.write(content);
  out.write("");
  try {
    const Recording recording = convertMbot(in.path(), out.path());
    FUZZ_CHECK(recording.scans > 0);
    fuzz::checkConverted(recording, out.path());
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  convert({reinterpret_cast<const char*>(data), size});
  constexpr std::array<std::uint64_t, 7> kTypes = {0x89dc5b879a5056cf, 0x7d090bfb221d74f9, 0x8dc5a028fca42ff9,
                                                   0xed966784146237ec, 0xa8b04e85ffa9d1d1, 0x5d3f1ec742142382,
                                                   0x1f317af1246276ac};
  fuzz::Input input({data, size});
  std::string log;
  for (std::int64_t i = 0; !input.atEnd(); ++i) {
    const std::uint64_t type = kTypes[input.take<std::uint8_t>() % kTypes.size()];
    std::vector<std::uint8_t> payload;
    for (int shift = 56; shift >= 0; shift -= 8) payload.push_back(static_cast<std::uint8_t>(type >> shift));
    const fuzz::Bytes part = input.takeBytes(input.take<std::uint8_t>());
    payload.insert(payload.end(), part.begin(), part.end());
    appendRecord(log, i, input.take<std::int64_t>(), type == kTypes[6] ? "ODOMETRY" : "X" + std::to_string(type % 8),
                 payload);
  }
  convert(log);
  return 0;
}
