// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/situation_means.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace slam {
namespace {

void add(SituationMeans::Figures& sum, const AblationFigures& figures) {
  const auto count = static_cast<double>(figures.errors.size());
  sum.error += count > 0.0 ? std::reduce(figures.errors.begin(), figures.errors.end()) / count
                           : std::numeric_limits<double>::quiet_NaN();
  sum.lost += figures.lost;
  sum.sure_and_wrong += figures.sure_and_wrong;
}

}  // namespace

std::string situationOf(std::string_view case_name) {
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t blank = std::min(case_name.find(' '), case_name.size());
  const std::size_t end =
      std::min(case_name.find_first_not_of(kDigits, std::min(blank + 1, case_name.size())), case_name.size());
  const bool seed = end > blank + 1 && (end == case_name.size() || case_name[end] == ',');
  return std::string(case_name.substr(0, blank)) + std::string(case_name.substr(seed ? end : blank));
}

std::vector<SituationMeans> situationMeans(const std::vector<AblationCase>& cases,
                                           const std::vector<AblationFigures>& with,
                                           const std::vector<AblationFigures>& without) {
  std::vector<SituationMeans> all;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string name = situationOf(cases[i].name);
    auto found = std::ranges::find(all, name, &SituationMeans::situation);
    if (found == all.end()) found = all.insert(all.end(), {name, 0, {}, {}});
    ++found->drives;
    add(found->with, with[i]);
    add(found->without, without[i]);
  }
  for (SituationMeans& one : all) {
    for (SituationMeans::Figures* figures : {&one.with, &one.without}) {
      figures->error /= one.drives;
      figures->lost /= one.drives;
      figures->sure_and_wrong /= one.drives;
    }
  }
  return all;
}

}  // namespace slam
