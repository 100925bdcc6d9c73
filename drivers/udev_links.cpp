// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/udev_links.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>

namespace slam {

std::vector<Claimant> claimantsOf(const std::filesystem::path& link, const std::filesystem::path& root) {
  std::vector<Claimant> claimants;
  constexpr std::string_view kDev = "/dev/", kByPath = "S:serial/by-path/", kSerial = "E:ID_SERIAL_SHORT=";
  const std::string path = link.string();
  if (!path.starts_with(kDev)) return claimants;
  const std::string wanted = "S:" + path.substr(kDev.size());
  std::error_code error;
  std::filesystem::directory_iterator entries(root / "run" / "udev" / "data", error), end;
  for (; !error && entries != end; entries.increment(error)) {
    const std::string entry = entries->path().filename().string();  // c188:0
    if (!entry.starts_with('c')) continue;
    Claimant claimant;
    bool claims = false;
    std::ifstream in(entries->path());
    for (std::string line; std::getline(in, line);) {
      claims = claims || line == wanted;
      if (line.starts_with(kByPath)) claimant.by_path = path.substr(0, kDev.size()) + line.substr(2);
      if (line.starts_with(kSerial)) claimant.serial = line.substr(kSerial.size());
    }
    if (!claims) continue;
    std::error_code unknown;
    const auto device = std::filesystem::canonical(root / "sys" / "dev" / "char" / entry.substr(1), unknown);
    claimant.name = unknown ? "device " + entry.substr(1) : device.filename().string();
    claimants.push_back(std::move(claimant));
  }
  std::sort(claimants.begin(), claimants.end(), [](const Claimant& a, const Claimant& b) { return a.name < b.name; });
  return claimants;
}

std::string describeClaimants(const std::filesystem::path& link, const std::vector<Claimant>& claimants) {
  if (claimants.size() < 2) return "";
  const bool same = std::all_of(claimants.begin(), claimants.end(), [&](const Claimant& claimant) {
    return !claimant.serial.empty() && claimant.serial == claimants.front().serial;
  });
  std::string text =
      (claimants.size() == 2 ? "two" : std::to_string(claimants.size())) + " devices claim " + link.string() + ": ";
  for (std::size_t i = 0; i < claimants.size(); ++i)
    text += (i == 0 ? "" : i + 1 == claimants.size() ? " and " : ", ") + claimants[i].name;
  return text + (same ? ", whose adapters have the same serial number " + claimants.front().serial : "") +
         "; which of them it names may change with each start";
}

}  // namespace slam
