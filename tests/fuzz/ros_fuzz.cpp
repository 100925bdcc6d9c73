// SPDX-License-Identifier: BSD-3-Clause
// The input is a bag: .bag, .mcap or .db3, by its first bytes.
#include <fstream>
#include <stdexcept>
#include <unistd.h>

#include "fuzz/fuzzing.hpp"
#include "fuzz/read_log.hpp"
#include "tools/convert/formats.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static const auto in = fuzz::scratchFile("_in"), out = fuzz::scratchFile("_out");  // SQLite takes no memfd
  std::ofstream(in, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const Recording recording = convertRos(in, out, {.wheel_radius = 0.1, .half_track = 0.2});
    FUZZ_CHECK(recording.scans > 0);
    fuzz::checkConverted(recording, out);
  } catch (const std::runtime_error&) {
  }
  ::unlink(in.c_str());
  ::unlink(out.c_str());
  return 0;
}
