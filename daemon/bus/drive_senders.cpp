// SPDX-License-Identifier: BSD-3-Clause
#include "bus/drive_senders.hpp"

#include <algorithm>

namespace slam {
namespace {

std::string nameOf(DriveSenders::Sender sender) {
  std::string name;
  for (int byte = 5; byte >= 2; --byte) {
    name += std::to_string(sender >> 8 * byte & 0xFF);
    name += byte > 2 ? "." : ":";
  }
  return name + std::to_string(sender & 0xFFFF);
}

}  // namespace

DriveSenders::Entry& DriveSenders::entryOf(Sender sender, Timestamp now) {
  const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.sender == sender; });
  if (known != entries_.end()) return *known;
  const auto oldest = std::min_element(entries_.begin(), entries_.end(),
                                       [](const Entry& a, const Entry& b) { return a.received < b.received; });
  *oldest = {.sender = sender, .received = now};
  oldest->clock.begin(ahead_);
  return *oldest;
}

void DriveSenders::beginClocks(Duration ahead) {
  ahead_ = ahead;
  for (Entry& entry : entries_) entry.clock.begin(ahead);
}

const DriveSenders::Entry* DriveSenders::followed(Timestamp now) const {
  const Entry* chosen = nullptr;
  for (const Entry& entry : entries_) {
    if (!drives(entry, now)) continue;
    const bool before =
        chosen == nullptr || (order_ == DriveOrder::kFirst ? entry.began < chosen->began : entry.began > chosen->began);
    if (before) chosen = &entry;
  }
  return chosen;
}

bool DriveSenders::take(Sender from, bool zero, Timestamp now) {
  Entry& entry = entryOf(from, now);
  entry.received = now;
  if (zero) {
    for (Entry& other : entries_) other.stopped = other.stopped || (&other != &entry && drives(other, now));
    entry.began = {};
    entry.stopped = false;
    return true;
  }
  if (entry.began == Timestamp{} || now - entry.drove > kEnded) {
    entry.began = now;
    entry.stopped = false;
  }
  entry.drove = now;
  return followed(now) == &entry;
}

Problem DriveSenders::problem(Timestamp now) const {
  const Entry* driven = followed(now);
  std::string names;
  int count = 0;
  for (const Entry& entry : entries_) {
    if (entry.received == Timestamp{} || now - entry.received > kReported) continue;
    const bool drives_on = entry.began != Timestamp{} && now - entry.drove <= kEnded;
    const char* does = &entry == driven             ? " is driven"
                       : drives_on && entry.stopped ? " was stopped by another one's zero"
                       : drives_on                  ? " waits"
                       : entry.began == Timestamp{} ? " sends zeros"
                                                    : " has ended";
    names += (count++ == 0 ? "" : ", ") + nameOf(entry.sender) + does;
  }
  if (count < 2) return {};
  return {
      problem::kDriveSenders, {static_cast<double>(count)}, {names, order_ == DriveOrder::kFirst ? "first" : "last"}};
}

}  // namespace slam
