// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "tools/bench/ablation.hpp"

namespace slam {

/// What came out of the drives of one situation, in the mean over their seeds, with a rule and without it.
struct SituationMeans {
  std::string situation;  ///< a case's name without its seed
  int drives = 0;
  struct Figures {
    double error = 0.0;           ///< [m] NaN: the situation has none
    double lost = 0.0;            ///< [1]
    double sure_and_wrong = 0.0;  ///< [1]
  } with, without;
};

/// A case's name without its seed, the number behind its first word: "home, late" of "home 2, late".
std::string situationOf(std::string_view case_name);

/// In the order of the first drive of each. @pre the three have one size
std::vector<SituationMeans> situationMeans(const std::vector<AblationCase>& cases,
                                           const std::vector<AblationFigures>& with,
                                           const std::vector<AblationFigures>& without);

}  // namespace slam
