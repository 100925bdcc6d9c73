// SPDX-License-Identifier: BSD-3-Clause
// Cuts the power of a virtual robot again and again; see tools/powercut.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <random>
#include <regex>
#include <set>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "store/log_folder.hpp"
#include "vm/robot.hpp"
#include "vm/write_log.hpp"

namespace slam::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const std::string kBin = SLAMD_BINARY_DIR;
constexpr auto kStartLimit = 600s;     // of a machine that shares its processor with others
constexpr double kJournalLimit = 3.0;  // [s] of the guest: what is older than the journal's period and a slow disk
constexpr double kLogLimit = 3.0;      // [s] of the field log that a cut may cost

struct Options {
  int cuts = 10;
  std::uint64_t seed = 1;
  int states = 3;
  std::string folder;
};

std::string textOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Runs a program of the host. @return its exit status, -1: not in time
int run(const std::vector<std::string>& command, const fs::path& output) {
  return Process(command, output).wait(120s).value_or(-1);
}

/// What slamd has promised, by the console.
struct Promise {
  int generation = 0;   ///< that was called saved
  int keyframes = 0;    ///< that it had kJournalLimit before the last line
  double logged = 0.0;  ///< [s since the epoch] the field log reaches so far
};

/// What the machine has told until a moment.
struct Told {
  std::string map;
  std::optional<double> localised;  ///< [s] behind the start of slamd
  double driven = 0.0;              ///< [s] since, by the machine's clock
  double utc = 0.0;                 ///< [s since the epoch] of the last line; 0: not known yet
  Promise promise;

  explicit Told(const std::string& console) {
    std::istringstream lines(console.substr(0, console.rfind('\n') + 1));
    std::vector<std::pair<double, int>> keyframes;
    double started = 0.0, driving = 0.0, last = 0.0;  // [10 ms]
    double driving_utc = 0.0;                         // [s since the epoch]
    for (std::string word; lines >> word;) {
      double time = 0.0;
      if (word == "STARTS" && lines >> time) started = last = time;
      if (word == "DRIVES" && lines >> time >> driving_utc >> map) {
        localised = ((driving = last = time) - started) / 100.0;
      }
      if (word == "ALIVE" && lines >> time) last = std::max(last, time);
      if (int count = 0; word == "STATUS" && lines >> time >> count) keyframes.emplace_back(time, count);
      if (int number = 0; word == "SAVED" && lines >> time >> number) promise.generation = number;
    }
    driven = (last - driving) / 100.0;
    if (driving_utc > 0.0) utc = driving_utc + driven;
    if (driven >= kLogLimit) promise.logged = utc - kLogLimit;
    for (const auto& [time, count] : keyframes) {
      if (last - time >= 100.0 * kJournalLimit) promise.keyframes = std::max(promise.keyframes, count);
    }
  }
};

/// What a disk holds after a cut.
struct Found {
  std::string map;
  int generation = 0;
  int keyframes = 0;           ///< with the journal's
  std::set<std::string> logs;  ///< files with records, all readable, by run and number
  double logged = 0.0;         ///< [s since the epoch] the last record of all
  std::string remark;
  std::vector<std::string> losses;
};

/// What each file's bytes held, by their hash: they are replayed once.
using ReadLogs = std::map<std::size_t, double>;

/// Reads all field logs, and replays each alone, without repair.
void readLogs(const fs::path& logs, const fs::path& folder, ReadLogs& read, Found& found) {
  if (!fs::is_directory(logs)) return;  // the first run has not begun one
  for (const LogFile& file : logFilesIn(logs)) {
    const std::string name = file.run() + "/" + std::to_string(file.number);
    const std::string bytes = textOf(file.path);
    const std::size_t hash = std::hash<std::string>{}(bytes);
    if (!read.contains(hash)) {
      std::int64_t last = 0;   // [us]
      bool has_scans = false;  // one that has just begun may not: nothing to replay
      try {
        EventLogReader reader(file.path);
        for (LogEvent event; reader.next(event);) {
          if (last == 0 && event.channel != channel::kConfig)
            found.losses.push_back("log " + name + " begins with " + event.channel);
          last = std::max(last, event.utime);
          has_scans |= event.channel == channel::kScan;
        }
      } catch (const EmptyLog&) {
        continue;  // it had just begun: no more is lost than the limit, or that is a loss of its own
      }
      const fs::path output = folder / "replay.txt";
      if (has_scans && run({kBin + "/slam-replay", "--log", file.path}, output) != 0)
        found.losses.push_back("log " + name + ": " + textOf(output));
      read[hash] = static_cast<double>(last) / 1e6;
    }
    found.logs.insert(name);
    found.logged = std::max(found.logged, read[hash]);
  }
}

/// Looks into a disk with the host's programs, as the next boot would find it. @param image is changed
Found look(const fs::path& image, const fs::path& folder, ReadLogs& read) {
  Found found;
  const fs::path output = folder / "look.txt", state = folder / "state";
  fs::remove_all(state);
  fs::create_directories(state);
  // Replays ext4's journal. 1: something was put right.
  if (const int status = run({"e2fsck", "-fy", image}, output); status != 0 && status != 1) {
    found.losses.push_back("e2fsck " + std::to_string(status) + ": " + textOf(output));
    return found;
  }
  run({"debugfs", "-R", "rdump /var/lib/slamd " + state.string(), image}, output);
  const fs::path maps = state / "slamd" / "maps";
  if (!fs::is_directory(maps) || fs::is_empty(maps)) return found;  // slamd has not stored anything yet
  if (run({kBin + "/slamctl", "--maps", maps, "list"}, output) != 0) found.losses.push_back(textOf(output));
  std::istringstream lines(textOf(output));
  static const std::regex kRow(R"(([* ]) (\S+) +(\d+) +(\d+)  .{19}  (.*))");
  int stored = 0;
  for (std::string line; std::getline(lines, line);) {
    std::smatch row;
    if (std::regex_match(line, row, kRow)) {
      ++stored;
      if (row[1] == "*") found.map = row[2], found.generation = std::stoi(row[4]);
      if (row[5] != "good" && row[5] != "usable, in part damaged")
        found.losses.push_back(row[2].str() + " is " + row[5].str());
    } else if (line.find("cut off behind record") != std::string::npos) {
      found.remark = "journal torn";  // what was being written: that is what it is for
    } else if (line.starts_with("  ") && line.find("keyframes") == std::string::npos) {
      found.losses.push_back(line);
    }
  }
  if (stored > 1) found.losses.push_back(std::to_string(stored) + " maps");
  if (!found.map.empty()) {
    const int status = run({kBin + "/slamctl", "--maps", maps, "export", found.map, folder / "map"}, output);
    const std::string text = textOf(output);
    std::smatch count;
    static const std::regex kCount(R"(map of (\d+) keyframes)");
    if (status == 0 && std::regex_search(text, count, kCount)) {
      found.keyframes = std::stoi(count[1]);
    } else {
      found.losses.push_back("export: " + text);
    }
  }
  readLogs(state / "slamd" / "log", folder, read, found);
  return found;
}

/// @param logs that were there before
void demand(Found& found, const Promise& promise, const std::string& map, const std::set<std::string>& logs) {
  if (!map.empty() && found.map != map)
    found.losses.push_back("the map " + map + " is gone; there is \"" + found.map + "\"");
  if (found.generation < promise.generation) {
    found.losses.push_back("generation " + std::to_string(promise.generation) + " was called saved, " +
                           std::to_string(found.generation) + " is there");
  }
  if (found.keyframes < promise.keyframes) {
    found.losses.push_back(std::to_string(promise.keyframes) + " keyframes were journalled, " +
                           std::to_string(found.keyframes) + " are there");
  }
  if (found.logged < promise.logged) {
    found.losses.push_back("the field log ends " + std::to_string(kLogLimit + promise.logged - found.logged) +
                           " s before the cut");
  }
  for (const std::string& log : logs) {
    if (!found.logs.contains(log)) found.losses.push_back("log " + log + " is gone");
  }
}

class PowerCuts {
 public:
  explicit PowerCuts(const Options& options) : options_(options), folder_(options.folder), random_(options.seed) {}

  /// @return exit status
  int run() {
    if (const int status = robot_.prepare(folder_); status != 0) {
      std::fprintf(stderr, "powercut: %s\n", robot_.problem().c_str());
      return status;
    }
    if (!install()) return 1;
    std::printf(
        "| cut | when | localised [s] | unflushed writes: all, kept, torn | generation: saved, found | keyframes: due, "
        "found | "
        "logs | log lost [s] | more states | lost |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (int number = 1; number <= options_.cuts; ++number) cut(number);
    if (!again()) ++lost_;
    std::printf("\n%d power cuts, %d more states of the disk, %d of them with writes not flushed: %d lost something\n",
                options_.cuts, states_, states_cut_short_, lost_);
    std::printf("Read: %d times a map, %zu different log files; a cut took %.2f s of the log at most\n", maps_,
                read_.size(), worst_log_loss_);
    return lost_ == 0 ? 0 : 1;
  }

 private:
  bool install() {
    if (!robot_.choose("install_only", {"--slamd", kBin + "/..", kBin + "/slam-sim"})) {
      std::fprintf(stderr, "powercut: %s\n", robot_.problem().c_str());
      return false;
    }
    const auto machine = robot_.boot();
    if (machine->exitStatus(400s) != 0) {
      std::fprintf(stderr, "powercut: cannot install:\n%s\n", machine->report().c_str());
      return false;
    }
    std::fprintf(stderr, "%s\n", machine->console().substr(0, machine->console().find('\n')).c_str());
    return robot_.choose("until_cut");
  }

  double draw(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }

  /// When the console said what, by the number of writes before.
  struct Moment {
    std::size_t writes, console;
  };

  void cut(int number) {
    const fs::path log = folder_ / "write.log", running = folder_ / "running.img", looked = folder_ / "looked.img";
    copy(robot_.disk(), running);
    std::ofstream(log, std::ios::trunc);
    std::vector<Moment> moments;
    std::string console;
    // One in five in the start, where slamd reads the map and writes the first generation.
    const bool early = draw(0.0, 1.0) < 0.2;
    const std::string mark = early ? "STARTS" : "DRIVES";
    const double seconds = early ? draw(0.0, 5.0) : draw(2.0, 12.0);
    bool reached = false;
    {
      const auto machine =
          robot_.boot("driver=blklogwrites,file.driver=file,file.filename=" + running.string() +
                      ",log.driver=file,log.filename=" + log.string() + ",log-super-update-interval=1");
      const auto remember = [&] {
        // First the writes: what the console says later may rest on more of them, never on fewer.
        const std::size_t size = machine->console().size();
        if (!moments.empty() && moments.back().console == size) return;
        moments.push_back({writesOf(log), size});
      };
      reached = machine->waitFor(mark, kStartLimit, [&] { remember(), usleep(20000); }).has_value();
      // By the machine's clock, which is slower than the host's where that has other work; it tells it every second.
      const auto begin = Clock::now();
      const auto over = [&] {
        const double waited = std::chrono::duration<double>(Clock::now() - begin).count();
        return early ? waited >= seconds : waited >= 15.0 * seconds || Told(machine->console()).driven >= seconds;
      };
      while (reached && !over()) remember(), usleep(20000);
      if (!early) usleep(static_cast<useconds_t>(draw(0.0, 1e6)));
      // Half of them while it writes, which is a small part of the time.
      if (const std::size_t written = writesOf(log); draw(0.0, 1.0) < 0.5) {
        for (const auto limit = Clock::now() + 5s; writesOf(log) == written && Clock::now() < limit;) usleep(200);
        usleep(static_cast<useconds_t>(draw(0.0, 20e3)));
      }
      machine->kill();
      console = machine->console();
      if (!reached) std::fprintf(stderr, "powercut: no %s:\n%s\n", mark.c_str(), machine->report().c_str());
    }
    const WriteLog writes(log);
    const Told told(console);
    if (map_.empty()) map_ = told.map;
    std::vector<std::string> losses;
    if (!reached) losses.push_back("slamd does not go on");
    if (!told.map.empty() && told.map != map_) losses.push_back("slamd goes on in " + told.map + ", not in " + map_);

    // More states: of any moment of this run.
    int states = 0;
    for (; states < options_.states && !moments.empty() && writes.entries().size() > 1; ++states) {
      const auto at = static_cast<std::size_t>(draw(1.0, static_cast<double>(writes.entries().size())));
      Promise promise = promise_;
      for (const Moment& moment : moments) {
        if (moment.writes > at) break;
        promise = atLeast(promise, Told(console.substr(0, moment.console)).promise);
      }
      copy(robot_.disk(), looked);
      states_cut_short_ += writes.apply(looked, at, random_).unflushed > 0 ? 1 : 0;
      Found found = look(looked, folder_, read_);
      maps_ += found.map.empty() ? 0 : 1;
      demand(found, promise, known_ ? map_ : "", logs_);
      for (const std::string& loss : found.losses)
        losses.push_back("cut behind write " + std::to_string(at) + ": " + loss);
    }
    states_ += states;

    promise_ = atLeast(promise_, told.promise);
    known_ |= promise_.generation > 0;
    const WriteLog::Cut left = writes.apply(robot_.disk(), writes.entries().size(), random_);
    copy(robot_.disk(), looked);
    Found found = look(looked, folder_, read_);
    maps_ += found.map.empty() ? 0 : 1;
    demand(found, promise_, known_ ? map_ : "", logs_);
    logs_ = found.logs;
    std::optional<double> log_loss;  // [s]
    if (told.utc > 0.0)
      worst_log_loss_ = std::max(worst_log_loss_, *(log_loss = std::max(0.0, told.utc - found.logged)));
    losses.insert(losses.end(), found.losses.begin(), found.losses.end());
    if (!losses.empty()) keepEvidence(number);
    lost_ += losses.empty() ? 0 : 1;
    std::string words;
    for (const std::string& loss : losses) words += (words.empty() ? "" : "; ") + loss;
    std::replace(words.begin(), words.end(), '\n', ' ');
    std::printf(
        "| %d | %.1f s behind %s | %s | %d, %d, %d | %d, %d | %d, %d | %zu | %s | %d | %s |\n", number, seconds,
        mark.c_str(), told.localised ? std::to_string(*told.localised).substr(0, 4).c_str() : "-", left.unflushed,
        left.kept, left.torn, promise_.generation, found.generation, promise_.keyframes, found.keyframes,
        found.logs.size(), log_loss ? std::to_string(*log_loss).substr(0, 4).c_str() : "-", states,
        losses.empty() ? found.remark.empty() ? "nothing" : ("nothing (" + found.remark + ")").c_str() : words.c_str());
    std::fflush(stdout);
  }

  /// The boot behind the last cut.
  bool again() {
    const auto machine = robot_.boot();
    const bool goes_on = machine->waitFor("DRIVES", kStartLimit).has_value();
    usleep(200000);
    const bool same = map_.empty() || Told(machine->console()).map == map_;  // empty: no cut was behind the first map
    if (!goes_on || !same)
      std::fprintf(stderr, "powercut: slamd does not go on in %s:\n%s\n", map_.c_str(), machine->report().c_str());
    return goes_on && same;
  }

  static Promise atLeast(const Promise& a, const Promise& b) {
    return {std::max(a.generation, b.generation), std::max(a.keyframes, b.keyframes), std::max(a.logged, b.logged)};
  }

  static void copy(const fs::path& from, const fs::path& to) {
    if (test::run({"cp", "--sparse=always", "--reflink=auto", from, to}, to.string() + ".txt") != 0)
      throw std::runtime_error(textOf(to.string() + ".txt"));
  }

  static std::size_t writesOf(const fs::path& log) {
    std::ifstream in(log, std::ios::binary);
    std::uint64_t super[3] = {};
    in.read(reinterpret_cast<char*>(super), sizeof super);
    return in ? super[2] : 0;
  }

  /// Disk, writes and console of a cut that lost something.
  void keepEvidence(int number) const {
    const fs::path kept = folder_ / ("lost-" + std::to_string(number));
    fs::create_directories(kept);
    for (const char* name : {"disk.img", "write.log", "console.txt"}) {
      test::run({"cp", "--sparse=always", folder_ / name, kept}, folder_ / "keep.txt");
    }
    std::fprintf(stderr, "powercut: kept %s\n", kept.c_str());
  }

  const Options& options_;
  fs::path folder_;
  std::mt19937_64 random_;
  Robot robot_;
  std::string map_;
  bool known_ = false;  // the map was called saved
  Promise promise_;
  std::set<std::string> logs_;  // that were there behind the cut before
  ReadLogs read_;
  double worst_log_loss_ = 0.0;  // [s]
  int states_ = 0, states_cut_short_ = 0, maps_ = 0, lost_ = 0;
};

}  // namespace
}  // namespace slam::test

int main(int argc, char** argv) {
  CLI::App app("Cuts the power of a virtual robot and looks for what was lost", "powercut");
  slam::test::Options options;
  app.add_option("CUTS", options.cuts, "how many")->check(CLI::Range(1, 100000))->capture_default_str();
  app.add_option("--seed", options.seed, "of moments and of what the disk loses")->capture_default_str();
  app.add_option("--states", options.states, "further states of the disk to look into, for each cut")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--folder", options.folder, "of the disks; what lost something stays there")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    std::filesystem::create_directories(options.folder);
    return slam::test::PowerCuts(options).run();
  } catch (const std::exception& error) {
    std::cerr << "powercut: " << error.what() << "\n";
    return 1;
  }
}
