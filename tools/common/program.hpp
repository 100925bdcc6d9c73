// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <functional>
#include <string>

namespace slam {

/// Exit codes shared by all programs.
enum ExitCode : int { kDone = 0, kFailed = 1, kBadUsage = 2, kBadConfig = 78 };

/// Parses the command line and runs `body`. Gives every program the same --help (with `example` at its end), --version,
/// exit codes and one-line errors on stderr; a ConfigError is its whole message, in as many lines as it has problems.
int runProgram(CLI::App& app, int argc, char** argv, const std::string& version, const std::string& example,
               const std::function<int()>& body);

/// Takes numbers from `least` to `most`, both included; unlike CLI::Range no "nan".
CLI::Validator inRange(double least, double most);
/// Takes paths that end in a file's name.
CLI::Validator namesFile();

/// Writes progress on one line of a terminal; silent where stderr is not a terminal.
void showProgress(const std::string& text);
void endProgress();

}  // namespace slam
