// SPDX-License-Identifier: BSD-3-Clause
#include "problems/problem.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <type_traits>

namespace slam {
namespace {

static_assert(std::is_trivially_copyable_v<Problem> && sizeof(Problem) % sizeof(std::uint64_t) == 0);

/// A place holder's number. @param format behind the `#`: index, and its decimals or hexadecimal digits; s: a time,
/// whose tenths are left out from 10 on
std::string numberAs(std::string_view format, const std::array<double, Problem::kNumbers>& numbers) {
  const double value = numbers.at(static_cast<std::size_t>(format[0] - '0'));
  char text[64];
  if (format.size() < 3) {
    std::snprintf(text, sizeof text, "%.*f", format.ends_with('s') && value < 10.0 ? 1 : 0, value);
  } else if (format[1] == 'x') {
    std::snprintf(text, sizeof text, "%0*llx", format[2] - '0', static_cast<unsigned long long>(value));
  } else {
    std::snprintf(text, sizeof text, "%.*f", format[2] - '0', value);
  }
  return text;
}

std::string textAs(char index, std::string_view texts) {
  for (; index > '0'; --index) texts.remove_prefix(std::min(texts.find('\0') + 1, texts.size()));
  return std::string(texts.substr(0, texts.find('\0')));
}

std::string filled(std::string_view words, const std::array<double, Problem::kNumbers>& numbers,
                   std::string_view texts) {
  std::string out;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t open = std::min(words.find('{', begin), words.size()), close = words.find('}', open);
    out += words.substr(begin, open - begin);
    if (close == std::string_view::npos) break;
    const std::string_view place = words.substr(open + 1, close - open - 1);
    out += place[0] == '#' ? numberAs(place.substr(1), numbers) : textAs(place[0], texts);
    begin = close + 1;
  }
  return out;
}

}  // namespace

Problem::Problem(const ProblemKind& kind, std::initializer_list<double> numbers,
                 std::initializer_list<std::string_view> texts)
    : kind_(&kind) {
  std::copy_n(numbers.begin(), std::min(numbers.size(), kNumbers), numbers_.begin());
  auto at = texts_.begin();
  for (const std::string_view text : texts) {
    const auto room = texts_.end() - at - 1;
    at = std::copy_n(text.begin(), std::min(static_cast<std::ptrdiff_t>(text.size()), room), at);
    if (at != texts_.end() - 1) ++at;
  }
}

bool Problem::isSame(const Problem& other) const {
  const auto names = [](const Problem& problem) {
    std::string_view texts(problem.texts_.data(), kTextSize);
    for (std::size_t i = 0; i < kNames; ++i) texts.remove_prefix(std::min(texts.find('\0') + 1, texts.size()));
    return std::string_view(problem.texts_.data(), kTextSize - texts.size());
  };
  return kind_ == other.kind_ && names(*this) == names(other);
}

std::vector<std::string> Problem::texts() const {
  constexpr char kMostPlaces = 3;  // {0} to {2}
  std::vector<std::string> texts;
  for (char i = 0; i < kMostPlaces; ++i)
    texts.push_back(textAs(static_cast<char>('0' + i), {texts_.data(), kTextSize}));
  while (!texts.empty() && texts.back().empty()) texts.pop_back();
  return texts;
}

std::string Problem::cause() const {
  return kind_ == nullptr ? "" : filled(kind_->cause, numbers_, {texts_.data(), kTextSize});
}

std::string Problem::meanwhile() const {
  return kind_ == nullptr ? "" : filled(kind_->meanwhile, numbers_, {texts_.data(), kTextSize});
}

std::string Problem::fix() const {
  return kind_ == nullptr ? "" : filled(kind_->fix, numbers_, {texts_.data(), kTextSize});
}

std::string Problem::words(const std::string& otherwise) const {
  const std::string own = meanwhile();
  return sentenceOf(cause(), own.empty() ? otherwise : own, fix());
}

std::string sentenceOf(std::string cause, const std::string& meanwhile, const std::string& fix) {
  if (!meanwhile.empty()) cause += "; " + meanwhile;
  if (!fix.empty()) cause += (meanwhile.empty() ? ": " : "; fix: ") + fix;
  return cause;
}

void SharedProblem::store(const Problem& problem) {
  if (problem == stored_) return;
  stored_ = problem;
  Words words;
  std::memcpy(words.data(), &problem, sizeof words);
  const std::uint32_t version = version_.load(std::memory_order_relaxed);
  version_.store(version + 1, std::memory_order_relaxed);
  for (std::size_t i = 0; i < words.size(); ++i) words_[i].store(words[i], std::memory_order_release);
  version_.store(version + 2, std::memory_order_release);
}

Problem SharedProblem::load() const {
  Words words;
  for (;;) {
    const std::uint32_t before = version_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = words_[i].load(std::memory_order_acquire);
    if (before % 2 == 0 && version_.load(std::memory_order_relaxed) == before) break;
  }
  Problem problem;
  std::memcpy(static_cast<void*>(&problem), words.data(), sizeof words);
  return problem;
}

}  // namespace slam
