// SPDX-License-Identifier: BSD-3-Clause
// The input is a log of Mines ParisTech, one of Wean Hall or its map, by the first byte. A "*" in it stands for as many
// copies of the number before it as a line of that kind needs.
#include <stdexcept>
#include <string>

#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/read_log.hpp"
#include "tools/convert/formats.hpp"

namespace {

std::string expanded(slam::fuzz::Bytes bytes, int copies) {
  std::string text, number;
  for (const std::uint8_t byte : bytes) {
    if (byte != '*') {
      text.push_back(static_cast<char>(byte));
      number = byte == ' ' || byte == '\n' ? "" : number + static_cast<char>(byte);
    } else if (text.size() < 100000 && number.size() < 30) {
      for (int i = 0; i < copies; ++i) text += " " + number;
    }
  }
  return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static const fuzz::MemoryFile in, out;
  fuzz::Input input({data, size});
  const int kind = input.take<std::uint8_t>() % 3;
  in.write(expanded(input.rest(), kind == 0 ? 681 : 179));
  out.write("");
  try {
    if (kind == 2) {
      const MapImage map = readBeesoftMap(in.path());
      FUZZ_CHECK(map.cells.size() == static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
    } else {
      fuzz::checkConverted(kind == 0 ? convertMines(in.path(), out.path()) : convertWean(in.path(), out.path()),
                           out.path());
    }
  } catch (const std::runtime_error&) {
  }
  return 0;
}
