// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/recorder.hpp"

#include <algorithm>
#include <utility>

#include "bus/event_log.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr double kFlushRate = 10.0;  // [Hz] so much is lost when slamd is killed

}  // namespace

Recorder::Recorder(std::string name, std::unique_ptr<RecordSink> sink, std::size_t capacity)
    : sink_(std::move(sink)),
      capacity_(capacity),
      worker_({.name = std::move(name), .rate = kFlushRate}, [this] { tick(); }) {
  worker_.start();
}

void Recorder::add(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data) {
  const std::scoped_lock lock(mutex_);
  if (ending_ || pending_.records.size() + recordSize(channel, data) > capacity_) {
    ++counters_.dropped;
    if (!ending_ && !failing_ && waits_.until(monotonicNow()) == Duration(0)) ++starved_;
    return;
  }
  if (pending_.messages++ == 0) pending_.utime = utime;
  appendRecord(pending_.records, number_++, utime, channel, data);
}

void Recorder::tick() {
  bool last = false;
  {
    const std::scoped_lock lock(mutex_);
    last = ending_;
    if (block_.messages == 0) std::swap(block_, pending_);
  }
  const Timestamp now = monotonicNow();
  waits_.begin(now);
  sink_->tend();
  if (last || retry_.due(now)) {
    try {
      sink_->write(block_.records, block_.utime);
      counters_.written += std::exchange(block_.messages, 0);
      block_.records.clear();
      retry_.succeeded();
      problem_.set({});
      failing_ = false;
    } catch (const std::exception& error) {
      retry_.failed(now);
      problem_.set(sink_->problemOf(error));
      failing_ = true;
    }
  }
  waits_.end();
  if (!last) return;
  {
    const std::scoped_lock lock(mutex_);
    if (!failing_ && pending_.messages > 0) return;  // once more
  }
  waits_.begin(now);
  try {
    sink_->finish();
  } catch (const std::exception& error) {
    problem_.set(sink_->problemOf(error));
  }
  waits_.end();
  {
    const std::scoped_lock lock(mutex_);
    counters_.dropped += block_.messages + pending_.messages;
  }
  worker_.requestStop();
  end_.set();
}

bool Recorder::finish(Timestamp deadline) {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  if (!end_.waitFor(deadline - monotonicNow())) return false;
  worker_.stop();
  return !problem_.get();
}

StorageReport Recorder::report(Timestamp now) const {
  StorageReport report{{problem_.get()}, {}, waits_.until(now)};
  const std::uint64_t dropped = counters_.dropped, starved = std::min<std::uint64_t>(starved_, dropped);
  if (dropped > 0) {
    report.lost = {2 * starved > dropped ? problem::kMessagesStarved : problem::kMessagesLost,
                   {static_cast<double>(dropped)}};
  }
  return report;
}

}  // namespace slam
