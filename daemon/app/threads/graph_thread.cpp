// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/graph_thread.hpp"

namespace slam {
namespace {

constexpr double kGraphRate = 20.0;  // [Hz] keyframes come at a few per second

}  // namespace

GraphThread::GraphThread(const Config& config, const GraphEnds& ends, const WallClock& clock)
    : ends_(ends),
      policy_(config.store),
      work_(config, ends_, clock, policy_),
      jobs_(config, ends_, work_, policy_),
      worker_({.name = "graph", .rate = kGraphRate}, [this] { tick(); }) {}

void GraphThread::tick() {
  work_.tick();
  jobs_.tick();
  work_.sendChanges();
}

void GraphThread::finish() {
  work_.takeIn();
  work_.sendChanges();
}

}  // namespace slam
