// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <slam/problem_t.hpp>
#include <string>

#include "problems/problem.hpp"

namespace slam {

/// @param device that it is about @param fault slamctl doctor fails for it
inline problem_t toMessage(const std::string& device, const Problem& problem, bool fault) {
  problem_t message{};
  message.device = device;
  message.id = problem.id();
  message.level = fault ? 2 : 1;
  message.numbers.assign(problem.numbers().begin(), problem.numbers().end());
  message.nnumbers = static_cast<std::int32_t>(message.numbers.size());
  message.texts = problem.texts();
  message.ntexts = static_cast<std::int32_t>(message.texts.size());
  message.cause = problem.cause();
  message.meanwhile = problem.meanwhile();
  message.fix = problem.fix();
  return message;
}

}  // namespace slam
