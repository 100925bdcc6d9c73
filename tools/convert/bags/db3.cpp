// SPDX-License-Identifier: BSD-3-Clause
// The tables are those of rosbag2_storage_sqlite3: topics, messages, and in newer ones message_definitions.
#include <map>
#include <stdexcept>

#include "tools/convert/bags/decompress.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/sqlite.hpp"

namespace slam {
namespace {

constexpr int kLargestValue = 1 << 26;  // [bytes]

std::string textIn(sqlite3_stmt* statement, int column) {
  const auto* text = sqlite3_column_text(statement, column);
  return text == nullptr ? std::string()
                         : std::string(reinterpret_cast<const char*>(text),
                                       static_cast<std::size_t>(sqlite3_column_bytes(statement, column)));
}

class Db3 : public RosSource {
 public:
  explicit Db3(const std::filesystem::path& file) : RosSource(file) {
    // "immutable": a recorder's journal beside it is not looked for, and nothing is locked or written.
    std::string uri = "file:";
    for (const char c : std::filesystem::absolute(file).string()) {
      char word[4];
      std::snprintf(word, sizeof(word), "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
      uri += c == '/' ? "/" : word;
    }
    sqlite3* database = nullptr;
    const bool journal = std::filesystem::exists(file.string() + "-wal");
    const int opened = sqlite3_open_v2((uri + (journal ? "?mode=ro" : "?mode=ro&immutable=1")).c_str(), &database,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    database_.reset(database);
    if (opened != SQLITE_OK) throw std::runtime_error(file.string() + ": cannot open: " + sqlite3_errmsg(database));
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kLargestValue);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_progress_handler(
        database, kStepsAtOnce, [](void* self) { return static_cast<Db3*>(self)->isTooMuch(); }, this);
    readTopics(file);
    select(0);
  }

  bool next(RosMessage& message) override {
    while (messages_) {
      steps_ = 0;
      const int status = sqlite3_step(messages_.get());
      if (status == SQLITE_INTERRUPT)
        throw std::runtime_error(name() + ": a row of it takes for ever; it is no recording");
      if (status == SQLITE_ROW) {
        skip_ = 1;
        last_ = sqlite3_column_int64(messages_.get(), 0);
        if (read(message)) return true;
        continue;
      }
      if (status == SQLITE_DONE) break;
      // A damaged page: what is behind it may be sound.
      if (skip_ == 1) damage(name() + ": damage behind message " + std::to_string(last_) + ": " + error());
      if (skip_ > kFarthest || ++attempts_ > kMostAttempts) break;
      select(last_ += skip_);
      skip_ *= 2;
    }
    messages_.reset();
    return false;
  }

 private:
  static constexpr std::int64_t kFarthest = std::int64_t{1} << 24;  // messages that a damage may hide
  static constexpr int kMostAttempts = 10000;

  static constexpr int kStepsAtOnce = 100000, kMostSteps = 500;  // of SQLite's machine, and times so many for a row

  int isTooMuch() { return ++steps_ > kMostSteps ? 1 : 0; }
  /// A view or a virtual table may do anything, or nothing for ever.
  bool isTable(const std::string& table) const {
    const Statement kind = prepare("SELECT 1 FROM sqlite_master WHERE name = '" + table +
                                   "' AND type = 'table' AND sql LIKE 'CREATE TABLE%'");
    return kind && sqlite3_step(kind.get()) == SQLITE_ROW;
  }
  std::string error() const { return sqlite3_errmsg(database_.get()); }
  Statement prepare(const std::string& query) const { return slam::prepare(database_, query); }
  /// Not in the order of time, which would need an index or much memory.
  void select(std::int64_t behind) {
    messages_ = prepare("SELECT id, topic_id, timestamp, data FROM messages WHERE id > " + std::to_string(behind) +
                        " ORDER BY id");
  }

  void readTopics(const std::filesystem::path& file) {
    for (const char* const table : {"topics", "messages"}) {
      if (!isTable(table)) throw std::runtime_error(file.string() + ": not a bag of ROS 2: it has no table " + table);
    }
    const Statement topics = prepare("SELECT id, name, type, serialization_format FROM topics");
    if (!topics) throw std::runtime_error(file.string() + ": not a bag of ROS 2: " + error());
    std::map<std::string, std::pair<std::string, std::string>> definitions;  // encoding and text of a type
    if (const Statement table =
            !isTable("message_definitions")
                ? Statement()
                : prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")) {
      while (sqlite3_step(table.get()) == SQLITE_ROW && definitions.size() < kMostTopics) {
        definitions[rosTypeName(textIn(table.get(), 0))] = {textIn(table.get(), 1), textIn(table.get(), 2)};
      }
    }
    while (sqlite3_step(topics.get()) == SQLITE_ROW && topics_.size() < kMostTopics) {
      RosTopic topic{.name = textIn(topics.get(), 1), .type = rosTypeName(textIn(topics.get(), 2))};
      const std::string format = textIn(topics.get(), 3);
      topic.encoding = format == "cdr" ? RosEncoding::kCdr : RosEncoding::kOther;
      if (format != "cdr") topic.remark = "its messages are written in " + format + ", which is not read";
      if (const auto at = definitions.find(topic.type); at != definitions.end()) {
        const auto& [encoding, text] = at->second;
        if (encoding == "ros2msg" || text.empty())
          topic.definition = text;
        else
          topic.remark = "its messages are described in " + encoding + ", which is not read";
      }
      topics_.emplace(sqlite3_column_int64(topics.get(), 0), std::move(topic));
    }
  }

  bool read(RosMessage& message) {
    const auto topic = topics_.find(sqlite3_column_int64(messages_.get(), 1));
    if (topic == topics_.end()) {
      damage(name() + ": message " + std::to_string(last_) + " is of a topic that is not described");
      return false;
    }
    message.topic = &topic->second;
    message.received = sqlite3_column_int64(messages_.get(), 2) / 1000;
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(messages_.get(), 3));
    message.data = {data, data == nullptr ? 0 : static_cast<std::size_t>(sqlite3_column_bytes(messages_.get(), 3))};
    countUnpacked(message.data.size());
    constexpr std::uint8_t kZstd[] = {0x28, 0xB5, 0x2F, 0xFD};  // each message compressed, as rosbag2 may
    if (message.data.size() > 4 && std::equal(std::begin(kZstd), std::end(kZstd), data)) {
      if (!decompress("zstd", message.data, message_)) {
        damage(name() + ": message " + std::to_string(last_) + " cannot be unpacked");
        return false;
      }
      countUnpacked(message_.size());
      message.data = message_;
    }
    return true;
  }

  Database database_;
  std::map<std::int64_t, RosTopic> topics_;
  Statement messages_;
  std::vector<std::uint8_t> message_;
  int steps_ = 0;  // times kStepsAtOnce, since the last row
  std::int64_t last_ = 0, skip_ = 1;
  int attempts_ = 0;
};

}  // namespace

std::unique_ptr<RosSource> openDb3(const std::filesystem::path& file) { return std::make_unique<Db3>(file); }

}  // namespace slam
