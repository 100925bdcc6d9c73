// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string_view>

#include "problems/problem.hpp"

namespace slam::test {

inline constexpr ProblemKind kOfTest{"of_a_test", "{0}"};

/// A problem that a test gives words to, in place of one of the table.
inline Problem problemOf(std::string_view words) { return {kOfTest, {}, {words}}; }

}  // namespace slam::test
