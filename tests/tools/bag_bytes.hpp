// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <bzlib.h>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <lz4frame.h>
#include <sqlite3.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>
#include <zlib.h>
#include <zstd.h>

/// Writes bags of ROS byte by byte, for tests and seeds.
namespace slam::test {

/// Little-endian numbers and texts; aligned as CDR where asked for.
class Wire {
 public:
  explicit Wire(bool cdr = false) : cdr_(cdr) {
    if (cdr_) bytes_ = std::string("\0\1\0\0", 4);
  }
  template <typename T>
  Wire& put(T value) {
    if (cdr_) bytes_.append((sizeof(T) - (bytes_.size() - 4) % sizeof(T)) % sizeof(T), '\0');
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  Wire& text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size() + (cdr_ ? 1 : 0)));
    bytes_ += value;
    if (cdr_) bytes_ += '\0';
    return *this;
  }
  Wire& raw(const std::string& value) {
    bytes_ += value;
    return *this;
  }
  template <typename T>
  Wire& all(const std::vector<T>& values) {
    put(static_cast<std::uint32_t>(values.size()));
    for (const T value : values) put(value);
    return *this;
  }
  Wire& header(std::int64_t us, const std::string& frame) {
    if (!cdr_) put(std::uint32_t{7});
    put(static_cast<std::uint32_t>(us / 1000000));
    put(static_cast<std::uint32_t>(us % 1000000 * 1000));
    return text(frame);
  }
  Wire& zeros(int count) {
    for (int i = 0; i < count; ++i) put(0.0);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  bool cdr_;
  std::string bytes_;
};

inline std::string scanBytes(bool cdr, std::int64_t us, const std::vector<float>& ranges,
                             const std::string& frame = "laser", float range_max = 10.0F) {
  Wire wire(cdr);
  wire.header(us, frame).put(-1.0F).put(1.0F).put(0.5F).put(0.001F).put(0.1F).put(0.1F).put(range_max);
  return wire.all(ranges).all(std::vector<float>{}).bytes();
}

inline std::string odometryBytes(bool cdr, std::int64_t us, double x, double yaw,
                                 const std::string& child = "base_link") {
  Wire wire(cdr);
  wire.header(us, "odom").text(child).put(x).put(0.0).put(0.0).zeros(2);
  return wire.put(std::sin(yaw / 2)).put(std::cos(yaw / 2)).zeros(36 + 6 + 36).bytes();
}

inline std::string imuBytes(bool cdr, std::int64_t us, double rate, const std::string& frame = "imu") {
  Wire wire(cdr);
  wire.header(us, frame).zeros(3).put(1.0).zeros(9).zeros(2).put(rate).zeros(9).zeros(2).put(9.81).zeros(9);
  return wire.bytes();
}

/// One transform: turned by roll about x, then by yaw about z.
inline std::string tfBytes(bool cdr, std::int64_t us, const std::string& parent, const std::string& child, double x,
                           double y, double yaw, double roll = 0.0) {
  Wire wire(cdr);
  wire.put(std::uint32_t{1}).header(us, parent).text(child).put(x).put(y).put(0.2);
  const double cy = std::cos(yaw / 2), sy = std::sin(yaw / 2), cr = std::cos(roll / 2), sr = std::sin(roll / 2);
  return wire.put(cy * sr).put(sy * sr).put(sy * cr).put(cy * cr).bytes();
}

inline std::string jointBytes(bool cdr, std::int64_t us, double left, double right) {
  Wire wire(cdr);
  wire.header(us, "").put(std::uint32_t{3}).text("arm").text("wheel_left_joint").text("wheel_right_joint");
  return wire.all(std::vector<double>{0.3, left, right}).all(std::vector<double>{}).all(std::vector<double>{}).bytes();
}

inline const char* const kScanDefinition =
    "# a scan\nstd_msgs/Header header # with a stamp\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
    "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n"
    "float32[] intensities\n";

inline std::string packed(const std::string& compression, const std::string& data) {
  std::string out(data.size() + data.size() / 2 + 4096, '\0');
  std::size_t size = 0;
  if (compression == "bz2") {
    auto length = static_cast<unsigned>(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &length, const_cast<char*>(data.data()), static_cast<unsigned>(data.size()), 9,
                             0, 0);
    size = length;
  } else if (compression == "lz4") {
    size = LZ4F_compressFrame(out.data(), out.size(), data.data(), data.size(), nullptr);
  } else if (compression == "zstd") {
    size = ZSTD_compress(out.data(), out.size(), data.data(), data.size(), 3);
  } else {
    return data;
  }
  out.resize(size);
  return out;
}

struct BagMessage {
  int topic;
  std::int64_t us;
  std::string data;
};
struct BagTopic {
  std::string name, type, definition = {}, md5 = "*", node = {};
};

inline std::string bagField(const std::string& name, const std::string& value) {
  return Wire().text(name + "=" + value).bytes();
}
inline std::string bagRecord(const std::string& header, const std::string& data) {
  return Wire().text(header).text(data).bytes();
}
template <typename T>
std::string rawNumber(T value) {
  return Wire().put(value).bytes();
}

/// A bag of ROS 1 with so many messages a chunk; 0: without chunks. No index.
inline std::string rosBag(const std::vector<BagTopic>& topics, const std::vector<BagMessage>& messages,
                          std::size_t chunk = 0, const std::string& compression = "none") {
  std::string bag = "#ROSBAG V2.0\n";
  bag += bagRecord(bagField("op", "\3") + bagField("index_pos", rawNumber(std::uint64_t{0})) +
                       bagField("conn_count", rawNumber(std::uint32_t{0})) +
                       bagField("chunk_count", rawNumber(std::uint32_t{0})),
                   std::string(100, ' '));
  std::string connections;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    connections +=
        bagRecord(bagField("conn", rawNumber(static_cast<std::uint32_t>(i))) + bagField("op", "\7") +
                      bagField("topic", topics[i].name),
                  bagField("topic", topics[i].name) + bagField("type", topics[i].type) +
                      bagField("md5sum", topics[i].md5) + bagField("message_definition", topics[i].definition) +
                      (topics[i].node.empty() ? "" : bagField("callerid", topics[i].node)));
  }
  std::string part = connections;
  std::size_t in_part = 0;
  const auto flush = [&] {
    if (part.empty()) return;
    bag += chunk == 0 ? part
                      : bagRecord(bagField("compression", compression) + bagField("op", "\5") +
                                      bagField("size", rawNumber(static_cast<std::uint32_t>(part.size()))),
                                  packed(compression, part));
    part.clear();
    in_part = 0;
  };
  for (const BagMessage& message : messages) {
    part += bagRecord(bagField("conn", rawNumber(static_cast<std::uint32_t>(message.topic))) + bagField("op", "\2") +
                          bagField("time", rawNumber(static_cast<std::uint32_t>(message.us / 1000000)) +
                                               rawNumber(static_cast<std::uint32_t>(message.us % 1000000 * 1000))),
                      message.data);
    if (++in_part == chunk) flush();
  }
  flush();
  return bag;
}

inline std::string mcapRecord(std::uint8_t op, const std::string& data) {
  return Wire().put(op).put(static_cast<std::uint64_t>(data.size())).raw(data).bytes();
}

/// An MCAP of ROS 2 with so many messages a chunk; 0: without chunks. No index, no end.
inline std::string mcapFile(const std::vector<BagTopic>& topics, const std::vector<BagMessage>& messages,
                            std::size_t chunk = 0, const std::string& compression = "",
                            const std::string& language = "ros2msg") {
  std::string file = "\x89MCAP0\r\n" + mcapRecord(1, Wire().text("ros2").text("test").bytes());
  std::string part;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const auto id = static_cast<std::uint16_t>(i + 1);
    part += mcapRecord(3, Wire().put(id).text(topics[i].type).text(language).text(topics[i].definition).bytes());
    part += mcapRecord(4, Wire().put(id).put(id).text(topics[i].name).text("cdr").put(std::uint32_t{0}).bytes());
  }
  std::size_t in_part = 0;
  const auto flush = [&] {
    if (part.empty()) return;
    const std::string small = packed(compression, part);
    const auto crc = static_cast<std::uint32_t>(
        ::crc32(0, reinterpret_cast<const Bytef*>(part.data()), static_cast<unsigned>(part.size())));
    file += chunk == 0 ? part
                       : mcapRecord(6, Wire()
                                           .put(std::uint64_t{0})
                                           .put(std::uint64_t{0})
                                           .put(static_cast<std::uint64_t>(part.size()))
                                           .put(crc)
                                           .text(compression)
                                           .put(static_cast<std::uint64_t>(small.size()))
                                           .raw(small)
                                           .bytes());
    part.clear();
    in_part = 0;
  };
  for (const BagMessage& message : messages) {
    const auto ns = static_cast<std::uint64_t>(message.us) * 1000;
    part += mcapRecord(5, Wire()
                              .put(static_cast<std::uint16_t>(message.topic + 1))
                              .put(std::uint32_t{0})
                              .put(ns)
                              .put(ns)
                              .raw(message.data)
                              .bytes());
    if (++in_part == chunk) flush();
  }
  flush();
  return file;
}

/// A bag of ROS 2 in SQLite. @param definitions with the table that newer ones have
inline void writeDb3(const std::string& path, const std::vector<BagTopic>& topics,
                     const std::vector<BagMessage>& messages, bool definitions = false) {
  sqlite3* database = nullptr;
  if (sqlite3_open(path.c_str(), &database) != SQLITE_OK) throw std::runtime_error("cannot write " + path);
  const auto run = [&](const std::string& query, const std::vector<std::string>& texts, const std::string* blob) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database, query.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
      throw std::runtime_error(sqlite3_errmsg(database));
    }
    int at = 1;
    for (const std::string& text : texts) sqlite3_bind_text(statement, at++, text.c_str(), -1, SQLITE_TRANSIENT);
    if (blob) sqlite3_bind_blob(statement, at, blob->data(), static_cast<int>(blob->size()), SQLITE_TRANSIENT);
    sqlite3_step(statement);
    sqlite3_finalize(statement);
  };
  run("BEGIN", {}, nullptr);
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
      "offered_qos_profiles TEXT)",
      {}, nullptr);
  run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)", {}, nullptr);
  if (definitions) {
    run("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT, "
        "encoded_message_definition TEXT, type_description_hash TEXT)",
        {}, nullptr);
  }
  for (std::size_t i = 0; i < topics.size(); ++i) {
    run("INSERT INTO topics VALUES(" + std::to_string(i + 1) + ", ?, ?, 'cdr', '')", {topics[i].name, topics[i].type},
        nullptr);
    if (definitions && !topics[i].definition.empty()) {
      run("INSERT INTO message_definitions VALUES(NULL, ?, 'ros2msg', ?, '')", {topics[i].type, topics[i].definition},
          nullptr);
    }
  }
  for (const BagMessage& message : messages) {
    run("INSERT INTO messages VALUES(NULL, " + std::to_string(message.topic + 1) + ", " +
            std::to_string(message.us * 1000) + ", ?)",
        {}, &message.data);
  }
  run("COMMIT", {}, nullptr);
  sqlite3_close(database);
}

}  // namespace slam::test
