// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "tools/slamctl/doctor.hpp"

/// `slamctl report`: one file for who looks into a bug.
namespace slam {

/// What a report is made of. A source that throws leaves its reason in its place.
struct ReportSources {
  std::string version;                    ///< of slamd
  std::function<Config()> configuration;  ///< effective
  std::function<Findings()> doctor;
  std::function<nlohmann::json()> status;  ///< of a running slamd
  std::filesystem::path logs;              ///< folder of the field logs; empty: none
};

struct ReportPart {
  std::string name, content;  ///< of the file in the report
  bool missing = false;       ///< the content is the reason
};

/// The configuration for others: without the web page's section, which holds its token.
std::string shareableConfiguration(Config config);

/// All parts but the log.
std::vector<ReportPart> reportParts(const ReportSources& sources);

/// Writes the parts, and the last two minutes of the field log where there is one.
/// @param out is never overwritten @return a line for each file in it
/// @throws std::runtime_error where it cannot be written
std::vector<std::string> writeReport(const ReportSources& sources, const std::filesystem::path& out);

}  // namespace slam
