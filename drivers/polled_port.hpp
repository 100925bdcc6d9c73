// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include "drivers/background_opener.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "drivers/line_device.hpp"
#include "drivers/retry.hpp"

namespace slam {

/// A serial port that a thread looks after at a fixed rate without ever waiting for bytes: opened when it is there, and
/// again when it was lost, less and less often.
class PolledPort {
 public:
  /// @param in_background opening is another thread's: due() is true when it has come to something
  PolledPort(std::string path, int baud, bool in_background = false, PortOpener open = openPort)
      : path_(std::move(path)),
        baud_(baud),
        open_(std::move(open)),
        opener_(in_background ? std::make_unique<BackgroundOpener>(path_, baud_, open_) : nullptr) {}

  bool isOpen() const { return stream_ != nullptr; }
  /// While it is not open: whether to try now. At once when a port that was missing is there again.
  bool due(Timestamp now) {
    if (asked_) return opener_->isDone();
    if (opener_ && !opener_->isClosed()) return false;
    const bool is_back = std::exchange(missing_, access(path_.c_str(), F_OK) != 0) && !missing_;
    const bool is_due = is_back || at_once_ || retry_.due(now);
    if (!is_due || !opener_) return is_due;
    opener_->useBaud(baud_);
    opener_->ask();
    asked_ = true;
    return false;
  }
  /// Opens it, once due() says so, and forgets what had come before. @return what is in the way; none when it
  /// is open
  Problem open(Timestamp now) {
    at_once_ = false;
    OpenedPort port = std::exchange(asked_, false) ? opener_->take() : open_(path_, baud_);
    if (!port.stream) {
      retry_.failed(now);
      return port.problem;
    }
    stream_ = std::move(port.stream);
    stream_->discardInput();
    return {};
  }
  /// Whether nothing of this program has the port open: who asked for it to be closed may have to wait.
  bool isReleased() const { return !isOpen() && (!opener_ || opener_->isClosed()); }
  /// It failed: the next attempt waits.
  void fail(Timestamp now) {
    release();
    retry_.failed(now);
  }
  /// From the next opening on. @param baud [bit/s]
  void useBaud(int baud) { baud_ = baud; }
  /// Closes it, to be opened at once at another baud rate [bit/s].
  void reopen(int baud) {
    release();
    useBaud(baud);
    at_once_ = true;
  }
  /// What comes makes sense: the next attempt after a failure is soon again.
  void succeeded() { retry_.succeeded(); }
  void close() { stream_.reset(); }

  /// Hands over the bytes that have come, one by one, as many as a tick may take.
  /// @param wait for the first of them @return false when the port has hung up
  template <typename Take>
  bool drain(Take&& take, Duration wait = Duration(0)) {
    std::array<std::uint8_t, 512> chunk;
    for (std::size_t taken = 0; taken < kMostBytes;) {
      const ReadResult result = stream_->read(chunk, taken == 0 ? wait : Duration(0));
      if (result.status == ReadResult::kClosed) return false;
      if (result.status == ReadResult::kTimeout) break;
      taken += result.size;
      for (std::size_t i = 0; i < result.size; ++i) take(chunk[i]);
    }
    return true;
  }
  void write(std::span<const std::uint8_t> bytes) { stream_->write(bytes); }

 private:
  void release() {
    if (stream_ && opener_) opener_->close(std::move(stream_));
    close();
  }

  static constexpr std::size_t kMostBytes = 16384;  // a tick: at 921600 bit/s one of 200 Hz brings 461
  std::string path_;
  int baud_;  // [bit/s]
  PortOpener open_;
  std::unique_ptr<BackgroundOpener> opener_;  // nullptr: none is wanted
  bool asked_ = false;                        // and has not been taken yet
  std::unique_ptr<ByteStream> stream_;
  Retry retry_{std::chrono::milliseconds(200)};
  bool missing_ = false, at_once_ = false;
};

/// A port for one device. What is wrong with it goes into the states of what the device measures; where the device does
/// not answer, the port is searched for who is there instead.
class DevicePort : public PolledPort {
 public:
  /// @param own as of WrongDevice @param states of what the device measures; they outlive this
  DevicePort(PortOf expected, const std::string& path, int baud, bool in_background, const PortOpener& open,
             LineDevice own, std::vector<DeviceStatus*> states)
      : PolledPort(path, baud, in_background, open),
        wrong_device_(expected, path, baud, open, own),
        states_(std::move(states)) {}

  /// While it is closed: goes on with the search, or opens the port when that is due. @return whether it is open now
  bool openWhenDue(Timestamp now) {
    if (wrong_device_.running()) {
      if (isReleased() && !wrong_device_.tick(now)) report(DeviceState::kFault, states_.front()->problem());
    } else if (due(now)) {
      const Problem problem = open(now);
      if (!problem) return true;
      wrong_device_.forget();
      report(DeviceState::kAbsent, problem);
    }
    return false;
  }
  /// @param otherwise where nobody else is known to be there
  void report(DeviceState state, const Problem& otherwise) {
    for (DeviceStatus* const status : states_) status->set(state, wrong_device_.found(otherwise));
  }
  /// It has hung up.
  void lose(Timestamp now) {
    fail(now);
    wrong_device_.forget();
    report(DeviceState::kAbsent, problem::kPortGone);
  }
  /// The device does not answer: the search begins. @param unknown where it finds nobody
  void giveUp(Timestamp now, const Problem& unknown) {
    fail(now);
    report(DeviceState::kFault, unknown);
    wrong_device_.ask();
  }
  /// The device answers.
  void succeeded() {
    PolledPort::succeeded();
    wrong_device_.forget();
  }

 private:
  WrongDevice wrong_device_;
  std::vector<DeviceStatus*> states_;
};

}  // namespace slam
