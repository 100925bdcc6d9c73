// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "app/bus/command_desk.hpp"
#include "app/bus/publisher.hpp"
#include "app/bus/sensor_receiver.hpp"
#include "app/channels.hpp"
#include "config/config.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *bus*: everything that touches LCM or the local socket. Publishes, takes commands, and takes samples of
/// sensors whose driver is "lcm". Without a network it keeps trying; whatever is published, and what it takes, also
/// goes into the record and the field log, if there are any.
class BusThread {
 public:
  BusThread(const Config& config, const BusEnds& ends, const WallClock& clock);
  ~BusThread() { worker_.stop(); }
  Worker& worker() { return worker_; }

  const Publisher& publisher() const { return publisher_; }
  SensorReceiver& sensors() { return sensors_; }
  LcmSender& poseSender() { return publisher_.link().sender(); }
  const UdpmUrl& url() const { return publisher_.link().url(); }
  Problem driveProblem() const { return drives_.problem(); }  ///< with speeds over LCM
  Problem socketProblem() const { return commands_.problem(); }

 private:
  void tick();
  void followClock();

  const BusEnds ends_;
  const WallClock& clock_;
  Publisher publisher_;
  SensorReceiver sensors_;
  DriveReceiver drives_;
  CommandDesk commands_;
  Duration followed_{0};  // by clock_, when the senders' clocks began
  Duration ahead_{0};     // of the wall clock, which was set back; our stamps are
  Worker worker_;
};

}  // namespace slam
