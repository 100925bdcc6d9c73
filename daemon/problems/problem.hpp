// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace slam {

/// A row of the table of problems. `{0}` is the first text of a Problem; `{#0}` its first number as a whole one,
/// `{#0.2}` with two decimals, `{#0x3}` hexadecimal with three digits, `{#0s}` a time, with tenths below 10.
struct ProblemKind {
  const char* id;              ///< for programs: stays when the words change
  const char* cause;           ///< what is wrong
  const char* meanwhile = "";  ///< what slamd does; empty: what it does without the device
  const char* fix = "";
};

/// Something that is wrong, as data: a row of the table, and what its words need. Fixed in size; making, copying and
/// comparing it allocates nothing.
class Problem {
 public:
  static constexpr std::size_t kNumbers = 4, kTextSize = 376, kNames = 2;

  Problem() = default;  ///< nothing is wrong
  /// @param numbers measure @param texts of which the first kNames name what is concerned, and the others give details;
  /// they are cut where all of them are longer than kTextSize bytes
  Problem(const ProblemKind& kind, std::initializer_list<double> numbers = {},
          std::initializer_list<std::string_view> texts = {});

  explicit operator bool() const { return kind_ != nullptr; }
  bool is(const ProblemKind& kind) const { return kind_ == &kind; }
  /// As SLAM_PROBLEMS has it; empty: nothing is wrong.
  const char* id() const { return kind_ == nullptr ? "" : kind_->id; }
  /// The two are one and the same, whatever their numbers and details.
  bool isSame(const Problem& other) const;
  bool operator==(const Problem&) const = default;
  const std::array<double, kNumbers>& numbers() const { return numbers_; }
  /// What its words need beside its numbers, without empty ones at the end.
  std::vector<std::string> texts() const;

  std::string cause() const;
  std::string meanwhile() const;
  std::string fix() const;
  /// Cause, what slamd does meanwhile, and fix in one sentence. @param otherwise what slamd does meanwhile, where the
  /// table has nothing
  std::string words(const std::string& otherwise = "") const;

 private:
  const ProblemKind* kind_ = nullptr;
  std::array<double, kNumbers> numbers_{};
  std::array<char, kTextSize> texts_{};  // each ended by '\0'
};

/// Cause, what slamd does meanwhile, and fix as one sentence; the last two may be empty.
std::string sentenceOf(std::string cause, const std::string& meanwhile, const std::string& fix);

/// A problem from one writing thread to any. Nobody waits for a lock; who reads while it is written reads again.
class SharedProblem {
 public:
  void store(const Problem& problem);
  Problem load() const;

 private:
  using Words = std::array<std::uint64_t, sizeof(Problem) / sizeof(std::uint64_t)>;

  Problem stored_;                         // of the writing thread: most often nothing changes
  std::atomic<std::uint32_t> version_{0};  // odd: being written
  std::array<std::atomic<std::uint64_t>, std::tuple_size_v<Words>> words_{};
};

}  // namespace slam
