// SPDX-License-Identifier: BSD-3-Clause
#include "problems/answer.hpp"

namespace slam {

Answer answerOf(std::initializer_list<Problem> parts) {
  Answer answer;
  for (const Problem& part : parts) {
    if (!part) continue;
    if (!answer.words.empty()) answer.words += answer.words.ends_with(':') ? " " : "; ";
    answer.words += part.words();
    answer.parts.push_back(part);
  }
  return answer;
}

Answer answerOf(const std::exception& error, const Problem& before) {
  if (const auto* const refused = dynamic_cast<const CommandRefused*>(&error))
    return answerOf({before, refused->why()});
  const std::string words = before.words();
  return {words + (words.empty() ? "" : " ") + error.what()};
}

}  // namespace slam
