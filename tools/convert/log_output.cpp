// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/log_output.hpp"

#include <stdexcept>
#include <string>

#include "bus/channels.hpp"
#include "bus/messages.hpp"
#include "core/plausibility.hpp"

namespace slam {

LogOutput::LogOutput(std::size_t memory) {
  sqlite3* database = nullptr;
  const int opened = sqlite3_open("", &database);  // a file without a name, which only what the cache cannot hold needs
  waiting_.reset(database);
  check(opened == SQLITE_OK);
  const std::string set_up = "PRAGMA journal_mode = OFF; PRAGMA cache_size = -" + std::to_string(memory / 1024 + 1) +
                             "; CREATE TABLE records(arrival INTEGER, channel TEXT, message BLOB); BEGIN";
  check(sqlite3_exec(database, set_up.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  insert_ = prepare(waiting_, "INSERT INTO records VALUES(?, ?, ?)");
}

void LogOutput::check(bool good) const {
  if (!good) throw std::runtime_error(std::string("cannot write a temporary file: ") + sqlite3_errmsg(waiting_.get()));
}

template <typename Message>
void LogOutput::append(std::int64_t arrival, const char* channel, const Message& message) {
  message_.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(message_.data(), 0, static_cast<int>(message_.size()));
  add(arrival, channel, message_);
}

void LogOutput::add(std::int64_t arrival, const LaserScan& scan, std::int64_t utime) {
  append(arrival, channel::kScan, toMessage(scan, utime));
}

void LogOutput::add(std::int64_t arrival, const WheelSample& sample, std::int64_t utime,
                    std::span<const double> angles) {
  if (!isPlausible(sample)) return void(++implausible_wheels_);
  append(arrival, channel::kWheels, toMessage(sample, utime, angles));
}

void LogOutput::add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime) {
  if (!isPlausible(sample)) return void(++implausible_imu_);
  append(arrival, channel::kImu, toMessage(sample, utime));
}

void LogOutput::add(std::int64_t arrival, const char* channel, std::span<const std::uint8_t> message) {
  sqlite3_bind_int64(insert_.get(), 1, arrival);
  sqlite3_bind_text(insert_.get(), 2, channel, -1, SQLITE_STATIC);
  sqlite3_bind_blob(insert_.get(), 3, message.data(), static_cast<int>(message.size()), SQLITE_STATIC);
  check(sqlite3_step(insert_.get()) == SQLITE_DONE);
  sqlite3_reset(insert_.get());
  empty_ = false;
}

void LogOutput::write(const std::filesystem::path& file, Recording* recording) {
  if (recording != nullptr) {
    recording->wheels -= implausible_wheels_;
    recording->imu -= implausible_imu_;
    for (int i = 0; i < implausible_wheels_ + implausible_imu_; ++i)
      recording->reject("wheels or IMU", "a number is beyond all that can be measured");
  }
  if (empty_) throw std::runtime_error(file.string() + ": not written: the input holds no sample");
  EventLogWriter log(file);
  bool written = true;
  const Statement sorted = prepare(waiting_, "SELECT * FROM records ORDER BY arrival, rowid");
  int status = SQLITE_ROW;
  while (written && (status = sqlite3_step(sorted.get())) == SQLITE_ROW) {
    const auto* message = static_cast<const std::uint8_t*>(sqlite3_column_blob(sorted.get(), 2));
    written = log.write(sqlite3_column_int64(sorted.get(), 0),
                        reinterpret_cast<const char*>(sqlite3_column_text(sorted.get(), 1)),
                        {message, static_cast<std::size_t>(sqlite3_column_bytes(sorted.get(), 2))});
  }
  if (!written || !log.flush()) throw std::runtime_error(file.string() + ": cannot write all of it; is the disk full?");
  check(status == SQLITE_DONE);
}

}  // namespace slam
