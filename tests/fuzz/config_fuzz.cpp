// SPDX-License-Identifier: BSD-3-Clause
// The input is a configuration file, then after a zero byte each one setting of the command line.
#include <string>
#include <vector>

#include "config/loader.hpp"
#include "config/printer.hpp"
#include "fuzz/fuzzing.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  const std::string input(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= size;) {
    const std::size_t end = std::min(input.find('\0', at), size);
    parts.push_back(input.substr(at, end - at));
    at = end + 1;
  }
  const std::vector<std::string> settings(parts.begin() + 1, parts.end());
  Config config;
  try {
    config = parseConfig(parts.front(), "fuzz.toml", settings);
  } catch (const ConfigError& error) {
    const std::string what = error.what();
    FUZZ_CHECK(what.starts_with("fuzz.toml:") || what.starts_with("--set "));
    return 0;
  }
  // What was accepted is accepted again as it is printed, and means the same.
  const std::string printed = printConfig(config);
  FUZZ_CHECK_NO_THROW(printConfig(parseConfig(printed, "printed.toml")) == printed);
  return 0;
}
