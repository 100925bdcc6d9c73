// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/terminal_console.hpp"

#include <istream>
#include <ostream>

#include "tools/common/program.hpp"
#include "tools/slamctl/setup/drive_calibration.hpp"
#include "tools/slamctl/setup/drive_progress.hpp"
#include "tools/slamctl/setup/interview.hpp"

namespace slam {
namespace {

std::string promptOf(const Question& question) {
  std::string text = question.error.empty() ? "" : question.error + "\n";
  text += question.text;
  if (question.kind == Question::kYesNo) return text + " [y/N] ";
  if (question.kind == Question::kText) return text + " (" + question.id + ") [" + question.otherwise + "] ";
  text += ":\n";
  for (std::size_t i = 0; i < question.choices.size(); ++i)
    text += "  " + std::to_string(i + 1) + ": " + question.choices[i] + "\n";
  return text + "Which one? Its number; or unplug the other and press Enter ";
}

}  // namespace

std::string TerminalConsole::answerTo(const Question& question) {
  out_ << promptOf(question) << std::flush;
  std::string line;
  if (in_ == nullptr) {
    out_ << "\n";
  } else if (!std::getline(*in_, line)) {
    in_ = nullptr;
    out_ << "\n";
  }
  return trimmed(line);
}

void TerminalConsole::show(const DriveProgress& progress) {
  if (progress.phase == DriveProgress::kBegins)
    out_ << "Scans and wheels come. Drive now: straight, and turning to both sides.\n" << std::flush;
  if (progress.phase == DriveProgress::kOver) return endProgress();
  showProgress("recording: " + std::to_string(static_cast<int>(progress.seconds)) + " s of " +
               std::to_string(static_cast<int>(progress.length)));
}

void TerminalConsole::show(const DriveCalibration& calibration) { print(calibration, out_); }

void TerminalConsole::showNoCalibration(const std::string& reason) { out_ << "Not calibrated: " << reason << "\n"; }

void TerminalConsole::show(const PlannedChanges& changes) {
  if (changes.is_same) {
    out_ << "\nNothing is to be changed in " << changes.file << ".\n";
    return;
  }
  out_ << (changes.lines.empty() ? "\nNo value changes.\n" : "\nChanges:\n");
  for (const std::string& line : changes.lines) out_ << "  " << line << "\n";
}

void TerminalConsole::show(const Findings& findings) {
  out_ << "\n" << std::flush;
  print(findings);
}

void TerminalConsole::show(const SetupOutcome& outcome) {
  if (outcome.service_runs)
    out_ << (*outcome.service_runs ? "The slamd service is started again.\n"
                                   : "The slamd service does not start: journalctl -u slamd -n 50\n");
  else if (outcome.isGood())
    out_ << "Next: sudo systemctl enable --now slamd, or restart it; then slamctl status\n";
}

}  // namespace slam
