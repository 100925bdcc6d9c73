// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <exception>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "problems/problem.hpp"

namespace slam {

/// What slamd answers to a command: words, and as data the rows of the table that they are made of.
struct Answer {
  std::string words;
  std::vector<Problem> parts = {};  ///< empty: the words are of no row, as what a damaged file holds
};

/// Why a command cannot be carried out, as a row of the table; what() is its words.
class CommandRefused : public std::runtime_error {
 public:
  explicit CommandRefused(const Problem& why) : std::runtime_error(why.words()), why_(why) {}
  const Problem& why() const { return why_; }

 private:
  Problem why_;
};

/// One sentence of several rows. A row that ends in a colon has the next one behind it; else a semicolon divides them.
Answer answerOf(std::initializer_list<Problem> parts);
/// @param before what goes before the reason @param error a CommandRefused, or any other, of which only words are left
Answer answerOf(const std::exception& error, const Problem& before = {});

}  // namespace slam
