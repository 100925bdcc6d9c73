// SPDX-License-Identifier: BSD-3-Clause
// The input is a table of scans.
#include <stdexcept>
#include <string_view>

#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/read_log.hpp"
#include "tools/convert/formats.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static const fuzz::MemoryFile in, out;
  in.write({reinterpret_cast<const char*>(data), size});
  out.write("");
  try {
    const Recording recording = convertCsv({.scans = in.path()}, out.path());
    FUZZ_CHECK(recording.scans > 0);
    fuzz::checkConverted(recording, out.path());
  } catch (const std::runtime_error&) {
  }
  return 0;
}
