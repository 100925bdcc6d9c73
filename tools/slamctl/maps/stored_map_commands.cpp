// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/stored_map_commands.hpp"

#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "slam/edits/edit_json.hpp"
#include "store/durable_file.hpp"
#include "tools/common/program.hpp"
#include "tools/slamctl/map_edits.hpp"
#include "tools/slamctl/maps/merge_maps.hpp"
#include "tools/slamctl/maps/refine_map.hpp"
#include "tools/slamctl/maps/stored_map.hpp"

namespace slam {
namespace {

constexpr std::size_t kLargestFile = 4 << 20;  // [bytes] of edits: 1000 outlines of 100 corners

std::string contentOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::string content(kLargestFile + 1, '\0');
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  content.resize(static_cast<std::size_t>(in.gcount()));
  if (content.size() > kLargestFile) throw std::runtime_error(file + " is larger than 4 MiB: no file of edits");
  return content;
}

/// Shows the share [1] of a long work that is done.
std::function<void(double)> percentShown(const std::string& work) {
  return [work, shown = -1](double share) mutable {
    const int percent = static_cast<int>(100.0 * share);
    if (std::exchange(shown, percent) != percent) showProgress(work + ": " + std::to_string(percent) + " %");
  };
}

}  // namespace

StoredMapCommands::StoredMapCommands(CLI::App& app) {
  const auto add = [&](const char* command, const char* what) {
    CLI::App* const added = app.add_subcommand(command, what);
    added->add_option("NAME", name_, "of a map")->required();
    return added;
  };
  CLI::App* const edit = add("edit", "carry out a file of edits in a map: all of them, or none");
  edit->add_option("FILE", file_, "JSON list of objects with kind and points (docs/api.md)")->required();
  CLI::App* const straighten = add("straighten", "turn a map so that most walls lie along its axes");
  straighten->add_option("--origin", origin_, "a place that is the origin from now on");
  CLI::App* const rename = add("rename", "give a map another name");
  rename->add_option("TO", to_, "letters, digits, - and _")->required();
  edit_ = edit, straighten_ = straighten, rename_ = rename;
  undo_ = add("undo", "undo the last edit of a map");
  delete_ = add("delete", "remove a map from the disk, for good");
  CLI::App* const merge = app.add_subcommand("merge", "make one map of two that show some of the same rooms");
  merge->add_option("A", name_, "a map, whose frame the new one has")->required();
  merge->add_option("B", second_, "a map that is looked for in A")->required();
  merge->add_option("--as", to_, "name of the new map; A and B stay")->required();
  merge->add_flag("--moved", furniture_moved_,
                  "furniture was moved in between; without it, floors that look alike stay apart");
  merge->add_option("--pictures", pictures_, "where two places fit, draw both: PREFIX-1.png and PREFIX-2.png");
  merge->footer("Example: slamctl merge house east-wing --as home");
  merge_ = merge;
  CLI::App* const refine = add("refine", "compute a map once more, offline; it stays where that makes it no better");
  refine->add_option("--as", to_, "name of the result; NAME stays");
  refine->footer("Example: slamctl refine house --as house-refined");
  refine_ = refine;
}

bool StoredMapCommands::parsed() const {
  for (const CLI::App* command : {edit_, undo_, straighten_, delete_, rename_, merge_, refine_})
    if (command->parsed()) return true;
  return false;
}

StoredMapCommands::Sent StoredMapCommands::carryOut(const std::string& directory, const Config& config,
                                                    std::int64_t utime) const {
  if (merge_->parsed()) {
    merge(directory, config);
    return {};
  }
  if (refine_->parsed()) {
    refine(directory, config);
    return {};
  }
  const StoredMap map{directory, name_, config.map};
  Sent sent;
  std::vector<EditCommand> commands;
  if (edit_->parsed()) {
    for (const std::string& one : editsIn(contentOf(file_), userName())) {
      commands.push_back({.kind = EditCommand::kAdd, .request = editRequestOf(one), .utime = utime});
      sent.emplace_back("map_edit", one);
    }
  } else if (undo_->parsed()) {
    commands.push_back({.kind = EditCommand::kUndo, .request = {}, .utime = utime});
    sent.emplace_back("map_undo", "");
  } else if (straighten_->parsed()) {
    sent.emplace_back("map_straighten", origin_);
  }
  try {
    if (!commands.empty()) {
      std::printf("%s\n", map.edit(commands).c_str());
    } else if (straighten_->parsed()) {
      std::printf("%s\n", map.straighten(origin_).c_str());
    } else if (delete_->parsed()) {
      map.remove();
      std::printf("map %s is removed\n", name_.c_str());
    } else {
      map.rename(to_);
      std::printf("map %s is now %s\n", name_.c_str(), to_.c_str());
    }
    return {};
  } catch (const FolderLocked&) {
    if (sent.empty()) throw std::runtime_error("slamd has map " + name_ + " open; slamctl load another one first");
    return sent;
  }
}

void StoredMapCommands::merge(const std::string& directory, const Config& config) const {
  const StoredMerge merge{.directory = directory,
                          .first = name_,
                          .second = second_,
                          .merged = to_,
                          .back_end = backEndConfig(config),
                          .grid = config.map,
                          .furniture_moved = furniture_moved_,
                          .pictures = pictures_};
  const std::string done = merge.carryOut(percentShown("merging"));
  endProgress();
  std::printf("%s\n", done.c_str());
}

void StoredMapCommands::refine(const std::string& directory, const Config& config) const {
  const StoredRefinement refinement{
      .directory = directory, .name = name_, .refined = to_, .back_end = backEndConfig(config), .grid = config.map};
  const auto announce = [](const std::string& words) { std::printf("%s\n", words.c_str()), std::fflush(stdout); };
  const std::string done = refinement.carryOut(announce, percentShown("refining"));
  endProgress();
  std::printf("%s\n", done.c_str());
}

}  // namespace slam
