// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/ros2_bag.hpp"

#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "tools/convert/bags/mcap_writer.hpp"
#include "tools/convert/sqlite.hpp"

namespace slam {
namespace {

struct Definition {
  const char* fields;
  std::vector<std::string> within = {};  // package/Type of the messages in it, also deeper ones
};

const std::map<std::string, Definition>& definitions() {
  static const std::vector<std::string> pose{"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose",
                                             "geometry_msgs/Point", "geometry_msgs/Quaternion"};
  static const auto with = [](std::vector<std::string> types, const std::vector<std::string>& more) {
    types.insert(types.begin(), "std_msgs/Header");
    types.insert(types.end(), more.begin(), more.end());
    types.emplace_back("builtin_interfaces/Time");
    return types;
  };
  static const std::map<std::string, Definition> all = {
      {"builtin_interfaces/Time", {"int32 sec\nuint32 nanosec\n"}},
      {"std_msgs/Header", {"builtin_interfaces/Time stamp\nstring frame_id\n"}},
      {"geometry_msgs/Point", {"float64 x\nfloat64 y\nfloat64 z\n"}},
      {"geometry_msgs/Vector3", {"float64 x\nfloat64 y\nfloat64 z\n"}},
      {"geometry_msgs/Quaternion", {"float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"}},
      {"geometry_msgs/Pose", {"geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"}},
      {"geometry_msgs/PoseWithCovariance", {"geometry_msgs/Pose pose\nfloat64[36] covariance\n"}},
      {"geometry_msgs/Twist", {"geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"}},
      {"geometry_msgs/TwistWithCovariance", {"geometry_msgs/Twist twist\nfloat64[36] covariance\n"}},
      {"geometry_msgs/Transform", {"geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"}},
      {"geometry_msgs/TransformStamped",
       {"std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"}},
      {"nav_msgs/MapMetaData",
       {"builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
        "geometry_msgs/Pose origin\n"}},
      {"sensor_msgs/LaserScan",
       {"std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
        "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n"
        "float32[] intensities\n",
        with({}, {})}},
      {"sensor_msgs/Imu",
       {"std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
        with({"geometry_msgs/Quaternion", "geometry_msgs/Vector3"}, {})}},
      {"sensor_msgs/JointState",
       {"std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
        with({}, {})}},
      {"nav_msgs/Odometry",
       {"std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
        "geometry_msgs/TwistWithCovariance twist\n",
        with({"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist", "geometry_msgs/Vector3"}, pose)}},
      {"geometry_msgs/PoseWithCovarianceStamped",
       {"std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n", with({}, pose)}},
      {"nav_msgs/OccupancyGrid",
       {"std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n",
        with({"nav_msgs/MapMetaData", "geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion"}, {})}},
      {"tf2_msgs/TFMessage",
       {"geometry_msgs/TransformStamped[] transforms\n",
        with({"geometry_msgs/TransformStamped", "geometry_msgs/Transform", "geometry_msgs/Vector3",
              "geometry_msgs/Quaternion"},
             {})}},
  };
  return all;
}

/// Of static transforms a late reader gets the last message, as from who published them.
std::string qosOf(const std::string& topic) {
  const std::string durability = topic == "/tf_static" || topic == "/map" ? "1" : "2";  // transient local, volatile
  return "- history: 3\n  depth: 0\n  reliability: 1\n  durability: " + durability +
         "\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: "
         "854775807"
         "\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
         "  avoid_ros_namespace_conventions: false\n";
}

class Db3Bag : public Ros2Bag {
 public:
  explicit Db3Bag(const std::filesystem::path& file) : file_(file) {
    std::filesystem::remove(file);
    sqlite3* database = nullptr;
    const int opened = sqlite3_open(file.c_str(), &database);
    database_.reset(database);
    if (opened != SQLITE_OK) fail();
    run("PRAGMA journal_mode = MEMORY; PRAGMA synchronous = OFF; BEGIN;"
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
        "INSERT INTO schema VALUES(3, 'humble');"
        "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
        "NOT NULL, offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data "
        "BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages(timestamp ASC);"
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL, "
        "encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);");
    insert_ = prepare(database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)");
    if (!insert_) fail();
  }

  ~Db3Bag() override {
    if (!database_) return;
    insert_.reset();
    database_.reset();
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }

  void write(const std::string& topic, const std::string& type, std::int64_t received, std::int64_t,
             const std::string& message) override {
    sqlite3_reset(insert_.get());
    sqlite3_bind_int64(insert_.get(), 1, topicOf(topic, type));
    sqlite3_bind_int64(insert_.get(), 2, 1000 * received);
    sqlite3_bind_blob64(insert_.get(), 3, message.data(), message.size(), SQLITE_STATIC);
    if (sqlite3_step(insert_.get()) != SQLITE_DONE) fail();
  }

  void close() override {
    insert_.reset();
    run("COMMIT");
    sqlite3* const database = database_.release();
    if (sqlite3_close(database) != SQLITE_OK) throw std::runtime_error(file_.string() + ": cannot be closed");
  }

 private:
  [[noreturn]] void fail() const {
    throw std::runtime_error(file_.string() + ": cannot write: " + sqlite3_errmsg(database_.get()));
  }
  void run(const char* statements) const {
    if (sqlite3_exec(database_.get(), statements, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }
  void insert(const std::string& query, const std::vector<std::string>& texts) const {
    const Statement statement = prepare(database_, query);
    if (!statement) fail();
    for (std::size_t i = 0; i < texts.size(); ++i)
      sqlite3_bind_text(statement.get(), static_cast<int>(i + 1), texts[i].c_str(), -1, SQLITE_STATIC);
    if (sqlite3_step(statement.get()) != SQLITE_DONE) fail();
  }
  std::int64_t topicOf(const std::string& topic, const std::string& type) {
    const auto [at, added] = topics_.try_emplace(topic, 0);
    if (!added) return at->second;
    insert("INSERT INTO topics(name, type, serialization_format, offered_qos_profiles) VALUES(?, ?, 'cdr', ?)",
           {topic, type, qosOf(topic)});
    at->second = sqlite3_last_insert_rowid(database_.get());
    insert(
        "INSERT INTO message_definitions(topic_type, encoding, encoded_message_definition, type_description_hash) "
        "VALUES(?, 'ros2msg', ?, '')",
        {type, rosDefinition(type)});
    return at->second;
  }

  std::filesystem::path file_;
  Database database_;
  Statement insert_;
  std::map<std::string, std::int64_t> topics_;
};

class McapBag : public Ros2Bag {
 public:
  explicit McapBag(const std::filesystem::path& file) : writer_(file, McapWriter::Messages::kRos2) {}
  void write(const std::string& topic, const std::string& type, std::int64_t received, std::int64_t utime,
             const std::string& message) override {
    auto at = channels_.find(topic);
    if (at == channels_.end())
      at = channels_.emplace(topic, writer_.addChannel(topic, type, rosDefinition(type))).first;
    writer_.write(at->second, received, utime, message);
  }
  void close() override { writer_.close(); }

 private:
  McapWriter writer_;
  std::map<std::string, std::uint16_t> channels_;
};

}  // namespace

CdrMessage& CdrMessage::time(std::int64_t utime) {
  return put(static_cast<std::int32_t>(utime / 1000000)).put(static_cast<std::uint32_t>(utime % 1000000 * 1000));
}

CdrMessage& CdrMessage::pose(const Pose2& pose) {
  put(pose.x).put(pose.y).zeros(3);
  return put(std::sin(0.5 * pose.theta)).put(std::cos(0.5 * pose.theta));
}

CdrMessage& CdrMessage::covariance(const double (&covariance)[9]) {
  constexpr int kPlane[] = {0, 1, 5};  // x, y and yaw of six
  double all[36] = {};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) all[6 * kPlane[row] + kPlane[column]] = covariance[3 * row + column];
  for (const double value : all) put(value);
  return *this;
}

std::unique_ptr<Ros2Bag> makeRos2Bag(const std::filesystem::path& file) {
  if (file.extension() == ".db3") return std::make_unique<Db3Bag>(file);
  if (file.extension() == ".mcap") return std::make_unique<McapBag>(file);
  throw std::runtime_error(file.string() + ": a bag of ROS 2 is named .db3 or .mcap");
}

std::string rosDefinition(const std::string& type) {
  const std::string known = type.substr(0, type.find('/')) + type.substr(type.rfind('/'));
  const Definition& definition = definitions().at(known);
  std::string text = definition.fields;
  for (const std::string& within : definition.within) {
    text += std::string(80, '=') + "\nMSG: ";
    text += within;
    text += '\n';
    text += definitions().at(within).fields;
  }
  return text;
}

}  // namespace slam
