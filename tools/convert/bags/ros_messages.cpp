// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/ros_messages.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "core/pose2.hpp"
#include "tools/convert/wire_reader.hpp"

namespace slam::ros {
namespace {

/// Fields of a message with those of the messages in it, one behind the other: what decides how its bytes are laid out.
struct Known {
  std::string_view md5;  // of ROS 1
  std::string_view fields;
};

constexpr std::string_view kPosition = "float64 x;float64 y;float64 z;";

const std::map<std::string, Known, std::less<>>& knownTypes() {
  static const auto types = [] {
    static const std::string beams =
        "@float32 angle_min;float32 angle_max;float32 angle_increment;float32 time_increment;float32 scan_time;float32 "
        "range_min;float32 range_max;";
    static const std::string position(kPosition), turn = position + "float64 w;";
    static const std::string scan = beams + "float32[] ranges;float32[] intensities;";
    static const std::string multi = beams + "ranges[]{float32[] echoes;}intensities[]{float32[] echoes;}";
    static const std::string imu = "@" + turn + "float64[9] orientation_covariance;" + position +
                                   "float64[9] angular_velocity_covariance;" + position +
                                   "float64[9] linear_acceleration_covariance;";
    static const std::string odometry = "@string child_frame_id;" + position + turn + "float64[36] covariance;" +
                                        position + position + "float64[36] covariance;";
    static const std::string transforms = "transforms[]{@string child_frame_id;" + position + turn + "}";
    return std::map<std::string, Known, std::less<>>{
        {"sensor_msgs/LaserScan", {"90c7ef2dc6895d81024acba2ac42f369", scan}},
        {"sensor_msgs/MultiEchoLaserScan", {"6fefb0c6da89d7c8abe4b339f5c2f8fb", multi}},
        {"sensor_msgs/Imu", {"6a62c6daae103f4ff57a132d6f95cec2", imu}},
        {"nav_msgs/Odometry", {"cd5e73d190d741a2f92e81eda573aca7", odometry}},
        {"sensor_msgs/JointState",
         {"3066dcd76a6cfaef579bd0f34173e9fd",
          "@string[] name;float64[] position;float64[] velocity;float64[] effort;"}},
        {"tf2_msgs/TFMessage", {"94810edda583a504dfda3829e70d7eec", transforms}},
        {"tf/tfMessage", {"94810edda583a504dfda3829e70d7eec", transforms}},
    };
  }();
  return types;
}

/// Messages within messages, where a definition leaves out what everybody knows.
constexpr std::pair<std::string_view, std::string_view> kWithin[] = {
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose", "Point position\nQuaternion orientation\n"},
    {"geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"},
    {"geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"sensor_msgs/LaserEcho", "float32[] echoes\n"},
};

constexpr std::string_view kHeader1 = "uint32 seq;time stamp;string frame_id;",
                           kHeader2 = "time stamp;string frame_id;";

bool isPrimitive(std::string_view type) {
  constexpr std::string_view kTypes[] = {"bool",    "byte",   "char",    "int8",  "uint8",   "int16",
                                         "uint16",  "int32",  "uint32",  "int64", "uint64",  "float32",
                                         "float64", "string", "wstring", "time",  "duration"};
  return std::find(std::begin(kTypes), std::end(kTypes), type) != std::end(kTypes);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// The text of a message and of those in it, by the lines of "=" between them.
class Definition {
 public:
  Definition(std::string_view text, bool ros1) : ros1_(ros1) {
    std::string name;  // the first is the message itself
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = trimmed(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.starts_with("MSG:")) {
        name = rosTypeName(std::string(trimmed(line.substr(4))));
      } else if (!line.starts_with("====") && sections_.size() < kMostSections) {
        sections_[name] += std::string(line) + "\n";
      }
    }
  }

  /// Fields as in Known. Empty: it cannot be laid out.
  std::string fields(const std::string& type) {
    std::string out;
    return flatten("", type.substr(0, type.find('/')), out, 0) ? out : std::string();
  }
  const std::string& missing() const { return missing_; }

 private:
  static constexpr std::size_t kMostSections = 100, kLongest = 20000;
  static constexpr int kDeepest = 10, kMostSteps = 1000;  // messages within messages

  std::optional<std::string> sectionOf(const std::string& name) const {
    if (const auto at = sections_.find(name); at != sections_.end()) return at->second;
    if (name == "std_msgs/Header") {
      return ros1_ ? "uint32 seq\ntime stamp\nstring frame_id\n" : "builtin_interfaces/Time stamp\nstring frame_id\n";
    }
    for (const auto& [within, text] : kWithin) {
      if (within == name) return std::string(text);
    }
    return std::nullopt;
  }

  bool flatten(const std::string& section, const std::string& package, std::string& out, int depth) {
    const auto found = sectionOf(section);
    if (!found || depth > kDeepest || out.size() > kLongest || ++steps_ > kMostSteps) {
      missing_ = section;
      return false;
    }
    std::string_view text = *found;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      line = trimmed(line.substr(0, line.find('#')));
      const std::size_t gap = line.find_first_of(" \t");
      if (line.empty() || gap == std::string_view::npos) continue;
      std::string type(line.substr(0, gap));
      const std::string_view rest = trimmed(line.substr(gap));
      const std::string name(rest.substr(0, rest.find_first_of(" \t=")));
      if (trimmed(rest.substr(name.size())).starts_with("=")) continue;  // a constant
      std::string array;
      if (const std::size_t bracket = type.find('['); bracket != std::string::npos) {
        array = type.substr(bracket);
        type.resize(bracket);
        if (array.starts_with("[<=")) array = "[]";
      }
      type.resize(std::min(type.find("<="), type.size()));
      if (type == "builtin_interfaces/Time" || type == "builtin_interfaces/msg/Time") type = "time";
      if (isPrimitive(type)) {
        out += type + array + " " + name + ";";
        continue;
      }
      std::string full = rosTypeName(type);
      if (full == "Header") full = "std_msgs/Header";
      if (full.find('/') == std::string::npos) full = package + "/" + full;
      if (!array.empty()) out += name + array + "{";
      if (!flatten(full, full.substr(0, full.find('/')), out, depth + 1)) return false;
      if (!array.empty()) out += "}";
    }
    return true;
  }

  bool ros1_;
  std::map<std::string, std::string> sections_;
  std::string missing_;
  int steps_ = 0;
};

/// The first field in which two lists differ.
std::string firstDifference(std::string_view known, std::string_view written) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < known.size() && i < written.size() && known[i] == written[i]; ++i) {
    if (known[i] == ';') begin = i + 1;
  }
  const auto field = [&](std::string_view fields) {
    const std::string_view rest = fields.substr(std::min(begin, fields.size()));
    const std::string text(rest.substr(0, std::min(rest.find(';'), rest.size())));
    return text.empty() ? std::string("nothing") : text;
  };
  return "it has " + field(written) + " where " + field(known) + " is known";
}

class Reader : public WireReader {
 public:
  explicit Reader(const RosMessage& message)
      : WireReader(body(message), message.topic->encoding == RosEncoding::kCdr),
        cdr_(message.topic->encoding == RosEncoding::kCdr) {
    constexpr std::uint8_t kLittleEndian[] = {0, 1};
    if (cdr_ && (message.data.size() < 4 ||
                 !std::equal(std::begin(kLittleEndian), std::end(kLittleEndian), message.data.begin()))) {
      fail();
    }
  }

  std::string string() {
    std::string_view text = WireReader::text();
    if (cdr_ && !text.empty() && text.back() == '\0') text.remove_suffix(1);  // CDR counts the zero at the end
    return std::string(text);
  }
  std::string frame() {
    std::string name = string();
    if (!name.empty() && name.front() == '/') name.erase(0, 1);
    return name;
  }
  Header header() {
    if (!cdr_) number<std::uint32_t>();  // seq
    const auto seconds = number<std::uint32_t>(), nanoseconds = number<std::uint32_t>();
    Header header;
    header.stamp = std::int64_t{seconds} * 1000000 + nanoseconds / 1000;
    header.frame = frame();
    return header;
  }
  Eigen::Vector3d vector() {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = number<double>();
    return v;
  }
  /// Not a turn (zeros): none.
  Eigen::Isometry3d pose() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = vector();
    Eigen::Vector4d q;
    for (int i = 0; i < 4; ++i) q[i] = number<double>();
    if (q.norm() > 1e-6 && q.allFinite()) T.linear() = Eigen::Quaterniond(q / q.norm()).toRotationMatrix();
    return T;
  }
  bool atEnd() const { return ok() && left() <= (cdr_ ? 7U : 0U); }  // some writers pad CDR

 private:
  static std::span<const std::uint8_t> body(const RosMessage& message) {
    const bool cdr = message.topic->encoding == RosEncoding::kCdr;
    return message.data.subspan(std::min<std::size_t>(cdr ? 4 : 0, message.data.size()));
  }
  bool cdr_;
};

/// Ranges of a scan, or the first echo of each beam.
std::vector<float> values(Reader& reader, bool echoes) {
  const std::uint32_t n = reader.count(4);
  std::vector<float> values(n);
  for (float& value : values) {
    if (!echoes) {
      value = reader.number<float>();
      continue;
    }
    const std::uint32_t count = reader.count(4);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto echo = reader.number<float>();
      if (i == 0) value = echo;
    }
  }
  return values;
}

/// Each fills what follows the header. @return false: it is none, whatever its size
bool fill(Reader& reader, const std::string& type, Scan& out) {
  const auto first = reader.number<float>();
  reader.number<float>();  // the last bearing, which follows
  const auto step = reader.number<float>(), time_step = reader.number<float>();
  reader.number<float>();  // time from scan to scan
  out.range_min = reader.number<float>();
  out.range_max = reader.number<float>();
  const bool echoes = type == "sensor_msgs/MultiEchoLaserScan";
  const auto ranges = values(reader, echoes), intensities = values(reader, echoes);
  const bool bearings =
      std::isfinite(first) && std::isfinite(step) && std::abs(first) < 100.0F && std::abs(step) < 7.0F;
  if (!reader.atEnd() || ranges.empty() || !bearings) return false;
  // Drivers that do not know their lidar's limits write 0, or what is none.
  constexpr double kFarthest = 200.0;  // [m] no lidar of these messages measures further
  if (!(out.range_min >= 0.0 && out.range_min < kFarthest)) out.range_min = 0.0;
  const bool limited = out.range_max > out.range_min;
  out.range_max = limited ? std::min(out.range_max, kFarthest) : 0.0;
  constexpr std::size_t kMost = LaserScan::kCapacity;
  const std::size_t stride = (ranges.size() + kMost - 1) / kMost;
  out.thinned = static_cast<int>(stride);
  out.scan.range_min = static_cast<float>(out.range_min);
  out.scan.range_max = static_cast<float>(limited ? out.range_max : kFarthest);
  const float seconds = std::isfinite(time_step) && time_step > 0.0F && time_step < 1.0F ? time_step : 0.0F;
  for (std::size_t i = 0; i < ranges.size(); i += stride) {
    const auto n = static_cast<float>(i);
    const double bearing = wrapAngle(static_cast<double>(first) + static_cast<double>(step) * static_cast<double>(i));
    const bool returned = ranges[i] >= out.scan.range_min && ranges[i] < out.scan.range_max && ranges[i] > 0.0F;
    const float intensity =
        intensities.size() == ranges.size() && std::isfinite(intensities[i]) ? intensities[i] : 0.0F;
    out.scan.push({.range = returned ? ranges[i] : 0.0F,
                   .bearing = static_cast<float>(bearing),
                   .time_offset = n * seconds,
                   .intensity = intensity});
  }
  return true;
}

bool fill(Reader& reader, Imu& out) {
  reader.skip<double>(4 + 9);
  out.gyro = reader.vector();
  reader.skip<double>(9);
  out.accel = reader.vector();
  const bool measured = reader.number<double>() != -1.0;  // as sensor_msgs/Imu says it
  reader.skip<double>(8);
  if (!measured || !out.accel.allFinite()) out.accel.setZero();
  return out.gyro.allFinite();
}

bool fill(Reader& reader, Odometry& out, std::string& child_frame) {
  child_frame = reader.frame();
  out.T_odom_child = reader.pose();
  reader.skip<double>(36 + 6 + 36);
  return out.T_odom_child.matrix().allFinite();
}

bool fill(Reader& reader, Joints& out) {
  const std::uint32_t names = reader.count(4);
  for (std::uint32_t i = 0; i < names && reader.ok(); ++i) out.names.push_back(reader.string());
  const std::uint32_t positions = reader.count(8);
  for (std::uint32_t i = 0; i < positions && reader.ok(); ++i) out.positions.push_back(reader.number<double>());
  for (int i = 0; i < 2; ++i) reader.skip<double>(reader.count(8));
  return true;
}

void fill(Reader& reader, std::vector<Transform>& out) {
  const std::uint32_t count = reader.count(64);
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    Transform& transform = out.emplace_back();
    transform.header = reader.header();
    transform.child_frame = reader.frame();
    transform.T_parent_child = reader.pose();
  }
  std::erase_if(out, [](const Transform& t) { return !t.T_parent_child.matrix().allFinite(); });
}

}  // namespace

bool isScan(const std::string& type) {
  return type == "sensor_msgs/LaserScan" || type == "sensor_msgs/MultiEchoLaserScan";
}

bool isTf(const std::string& type) { return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage"; }

bool isRead(const std::string& type) { return knownTypes().contains(type); }

std::string refusal(const RosTopic& topic) {
  if (!topic.remark.empty()) return topic.remark;
  const auto known = knownTypes().find(topic.type);
  if (known == knownTypes().end()) return "messages of type " + topic.type + " are not read";
  const bool ros1 = topic.encoding == RosEncoding::kRos1;
  Definition definition(topic.definition, ros1);
  const std::string written = topic.definition.empty() ? std::string() : definition.fields(topic.type);
  if (!definition.missing().empty()) {
    return "the definition of " + topic.type + " in the bag lacks " + definition.missing();
  }
  if (written.empty()) {
    if (!ros1 || topic.md5.empty() || topic.md5 == "*" || topic.md5 == known->second.md5) return {};
    return "the bag has no definition of " + topic.type + ", and its sum " + topic.md5 + " is not the known one";
  }
  std::string expected(known->second.fields);
  expected.replace(expected.find('@'), 1, ros1 ? kHeader1 : kHeader2);
  if (written == expected) return {};
  return "the definition of " + topic.type + " in the bag is another: " + firstDifference(expected, written);
}

std::string undecoded(const std::string& type) {
  const char* what = isScan(type)        ? "a scan"
                     : isTf(type)        ? "transforms"
                     : type == kImu      ? "an IMU reading"
                     : type == kOdometry ? "odometry"
                                         : "joint states";
  return std::string(what) + (isTf(type) || type == kJoints ? " that do not decode" : " that does not decode");
}

std::optional<Message> read(const RosMessage& message) {
  Reader reader(message);
  std::optional<Message> out(std::in_place);
  const std::string& type = message.topic->type;
  if (!isTf(type)) out->header = reader.header();
  bool good = true;
  if (isTf(type)) {
    fill(reader, out->content.emplace<std::vector<Transform>>());
  } else if (isScan(type)) {
    good = fill(reader, type, out->content.emplace<Scan>());
  } else if (type == kImu) {
    good = fill(reader, out->content.emplace<Imu>());
  } else if (type == kOdometry) {
    good = fill(reader, out->content.emplace<Odometry>(), out->child_frame);
  } else {
    good = fill(reader, out->content.emplace<Joints>());
  }
  if (!good || !reader.atEnd()) out.reset();
  return out;
}

}  // namespace slam::ros
