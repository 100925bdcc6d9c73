// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/page_files.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>
#include <zlib.h>

#include "build_paths.hpp"

namespace slam::page_files_test {
namespace {

constexpr const char* kPaths[] = {"/",        "/words.js",  "/german.js", "/page.js",  "/state.js",
                                  "/draw.js", "/hands.js",  "/access.js", "/drive.js", "/commands.js",
                                  "/maps.js", "/brush.js",  "/edit.js",   "/day.js",   "/tools.js",
                                  "/logs.js", "/worker.js", "/page.css",  "/icon.svg", "/manifest.webmanifest"};

// Of slamctl's set-up, which is nothing without the robot.
constexpr const char* kSetupPaths[] = {"/setup", "/setup.js", "/setup_words.js", "/setup.css"};

std::string contentOf(const char* path) {
  const PageFile* file = findPageFile(path);
  return file == nullptr ? "" : std::string(file->content);
}

/// All that a pattern's first group matches.
std::vector<std::string> matchesIn(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at) found.push_back((*at)[1]);
  return found;
}

/// Rows of slamd's table of problems as they stand in its headers, by id, with the words that several rows share.
std::map<std::string, std::string> problemRows() {
  std::string text;
  for (const char* file : {"devices", "sensors", "daemon", "answers"}) {
    std::ifstream in(std::string(SLAMD_SOURCE_DIR "/daemon/problems/") + file + ".hpp");
    text.append(std::istreambuf_iterator<char>(in), {});
  }
  std::map<std::string, std::string> shared, rows;
  const std::regex words(R"x((k\w+)(?:\[\])? =((?:\s*"[^"]*")+))x"), begin(R"x(ProblemKind k\w+\{\s*"([^"]*)",)x");
  for (std::sregex_iterator at(text.begin(), text.end(), words), end; at != end; ++at) shared[(*at)[1]] = (*at)[2];
  for (std::sregex_iterator at(text.begin(), text.end(), begin), end; at != end; ++at) {
    const auto from = static_cast<std::size_t>(at->position());
    std::string row = text.substr(from, text.find("};\n", from) - from);
    for (const std::string& name : matchesIn(row, R"(\b(k\w+)\b)")) {
      if (const auto found = shared.find(name); found != shared.end()) row += found->second;
    }
    rows[(*at)[1]] = row;
  }
  return rows;
}

/// The German rows, by id: cause, fix, what slamd does, joined by |.
std::map<std::string, std::string> germanRows() {
  const std::string text = contentOf("/german.js");
  std::map<std::string, std::string> rows;
  const std::size_t begin = text.find('`') + 1;
  std::istringstream lines(text.substr(begin, text.find('`', begin) - begin));
  for (std::string line; std::getline(lines, line);) {
    const std::string id = line.substr(0, line.find('|'));
    EXPECT_TRUE(rows.emplace(id, line.substr(id.size())).second) << id << " has two rows";
  }
  return rows;
}

/// [bytes] as a browser gets it
std::size_t compressed(const std::string& content) {
  std::string out(compressBound(content.size()), '\0');
  uLongf size = out.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(content.data()),
                     content.size()),
            Z_OK);
  return size;
}

TEST(PageFiles, AreSmall) {
  constexpr std::size_t kMost = 45'000;  // [bytes]
  std::size_t size = 0;
  for (const char* path : kPaths) size += compressed(contentOf(path));
  EXPECT_GT(size, kMost / 2);
  EXPECT_LT(size, kMost);
}

TEST(PageFiles, AreLightAtAFirstLook) {
  constexpr std::size_t kMost = 80'000;  // [bytes]
  const std::string page = contentOf("/");
  std::size_t size = page.size(), files = 1;
  for (const std::string& path : matchesIn(page, R"x(<(?:script|link)[^>]* (?:src|href)="([^"]+)")x")) {
    EXPECT_NE(contentOf(path.c_str()), "") << path;
    size += contentOf(path.c_str()).size();
    ++files;
  }
  EXPECT_GT(files, 8U);
  EXPECT_LT(size, kMost);
}

TEST(PageFiles, NeedNoOtherHost) {
  for (const char* path : kPaths) {
    EXPECT_NE(contentOf(path), "") << path;
    if (std::string(path) == "/icon.svg") continue;  // the name of its format is an address
    EXPECT_THAT(contentOf(path), testing::Not(testing::ContainsRegex("https?://"))) << path;
  }
}

TEST(PageFiles, OfTheSetUpAreSmallAndNeedNoOtherHost) {
  constexpr std::size_t kMost = 12'000;  // [bytes]
  std::size_t size = 0;
  for (const char* path : kSetupPaths) {
    EXPECT_NE(contentOf(path), "") << path;
    EXPECT_THAT(contentOf(path), testing::Not(testing::ContainsRegex("https?://"))) << path;
    size += compressed(contentOf(path));
  }
  EXPECT_GT(size, kMost / 2);
  EXPECT_LT(size, kMost);
  for (const std::string& path : matchesIn(contentOf("/setup"), R"x(<(?:script|link)[^>]* (?:src|href)="([^"]+)")x"))
    EXPECT_NE(contentOf(path.c_str()), "") << path;
}

TEST(PageFiles, AreAllKeptForAStartWithoutTheRobot) {
  for (const char* path : kPaths) {
    if (std::string(path) == "/worker.js") continue;
    EXPECT_THAT(contentOf("/worker.js"), testing::HasSubstr('"' + std::string(path) + '"'));
  }
}

/// Keys of a script's tables of texts, which are the same in both languages.
std::set<std::string> textKeys(const std::string& script, std::size_t least) {
  std::ifstream in(SLAMD_SOURCE_DIR "/tools/web/page/" + script);  // with its lines
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t german = text.find("\n  de: {"), end = text.find("\n};", german);
  EXPECT_NE(end, std::string::npos) << script;
  const char* const key = R"x((?:^|[\n ,])(\w+): ")x";
  const auto english_keys = matchesIn(text.substr(0, german), key);
  const auto german_keys = matchesIn(text.substr(german, end - german), key);
  EXPECT_GT(english_keys.size(), least);
  EXPECT_EQ(english_keys, german_keys);
  std::set<std::string> keys(english_keys.begin(), english_keys.end());
  EXPECT_EQ(keys.size(), english_keys.size()) << "a key stands twice in " << script;
  return keys;
}

/// Each text that a page's file uses is there.
void expectTexts(const std::set<std::string>& known, const char* path) {
  for (const std::string& used : matchesIn(contentOf(path), R"x(data-(?:text|label|title|placeholder)="(\w+)")x"))
    EXPECT_TRUE(known.contains(used)) << used << " in " << path;
  for (const std::string& used : matchesIn(contentOf(path), R"x(\b(?:t|button)\("(\w+)"[,)])x"))
    EXPECT_TRUE(known.contains(used)) << used << " in " << path;
}

TEST(PageFiles, HaveEachTextInBothLanguages) {
  std::set<std::string> known = textKeys("words.js", 80);
  for (const char* path : kPaths) expectTexts(known, path);
  known.merge(textKeys("setup_words.js", 30));
  for (const char* path : kSetupPaths) expectTexts(known, path);
}

TEST(PageFiles, AskEachQuestionOfTheSetUpInGerman) {
  std::string text;
  for (const char* file : {"proposal", "setup_command", "web/web_console"}) {
    std::ifstream in(std::string(SLAMD_SOURCE_DIR "/tools/slamctl/setup/") + file + ".cpp");
    text.append(std::istreambuf_iterator<char>(in), {});
  }
  std::vector<std::string> ids = matchesIn(text, R"x((?:\bask|agrees)\(\s*"([\w.]+)")x");
  for (const std::string& id : matchesIn(text, R"x(\.id = "(\w+)")x")) ids.push_back(id);
  EXPECT_GT(ids.size(), 20U);
  for (const std::string& id : ids) EXPECT_THAT(contentOf("/setup_words.js"), testing::HasSubstr('"' + id + "\": \""));
}

TEST(PageFiles, HaveGermanWordsForEachProblem) {
  const auto english = problemRows();
  auto german = germanRows();
  EXPECT_GT(english.size(), 200U);
  const std::string script = contentOf("/german.js");
  constexpr std::string_view kStops = "_stops";  // german.js makes these of their twins
  for (const auto& [id, row] : english) {
    const std::string twin = id.ends_with(kStops) ? id.substr(0, id.size() - kStops.size()) : "";
    const bool made = !twin.empty() && german.contains(twin) && script.find('"' + twin + '"') != std::string::npos;
    EXPECT_TRUE(german.contains(id) || made) << "tools/web/page/german.js has no row for " << id;
  }
  for (const auto& [id, row] : german) {
    ASSERT_TRUE(english.contains(id)) << "slamd has no problem " << id;
    for (const std::string& place : matchesIn(row, R"(\{([^}]*)\})"))
      EXPECT_THAT(english.at(id), testing::HasSubstr("{" + place + "}")) << id;
    EXPECT_GT(row.size(), 2U) << id;
  }
}

}  // namespace
}  // namespace slam::page_files_test
