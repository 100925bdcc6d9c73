// SPDX-License-Identifier: BSD-3-Clause
#include "matching/float_row.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "support/property.hpp"

namespace slam::float_row_test {
namespace {

FloatRow drawRow(double most) {
  FloatRow row{};
  for (std::size_t i = 0; i < kLanes; ++i) row[i] = static_cast<float>(test::draw(-most, most));
  return row;
}

RC_GTEST_PROP(FloatRow, ChoosesAndCountsAsEachNumberAlone, ()) {
  const FloatRow a = drawRow(1e6), b = drawRow(1e6);
  const IntRow less = a < b;
  const FloatRow chosen = choose(less, a, b), masked = where(less, a);
  int count = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    RC_ASSERT(chosen[i] == std::min(a[i], b[i]));
    RC_ASSERT(masked[i] == (a[i] < b[i] ? a[i] : 0.0F));
    count += a[i] < b[i];
  }
  RC_ASSERT(countOf(less) == count);
  RC_ASSERT(any(less) == (count > 0));
}

TEST(FloatRow, TransposesRowsToColumns) {
  FloatRow rows[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i)
    for (std::size_t k = 0; k < kLanes; ++k) rows[i][k] = static_cast<float>(10 * i + k);
  transpose(rows[0], rows[1], rows[2], rows[3]);
  for (std::size_t i = 0; i < kLanes; ++i)
    for (std::size_t k = 0; k < kLanes; ++k) EXPECT_EQ(rows[i][k], static_cast<float>(10 * k + i));
}

TEST(FloatRow, PairsBecomeColumns) {
  std::array<FloatPair, kLanes> pairs;
  for (std::size_t i = 0; i < kLanes; ++i)
    pairs[i] = singles(DoublePair{static_cast<double>(i), 0.1 + static_cast<double>(i)});
  FloatRow first, second;
  pairsOf(pairs, first, second);
  for (std::size_t i = 0; i < kLanes; ++i) {
    EXPECT_EQ(first[i], static_cast<float>(i));
    EXPECT_EQ(second[i], static_cast<float>(0.1 + static_cast<double>(i)));
  }
}

TEST(FloatRow, IsReadFromTheMiddleOfAnObject) {
  const struct {
    float before;
    std::array<float, kLanes> row;
  } object{0.5F, {1.0F, 2.0F, 3.0F, 4.0F}};
  const FloatRow row = loadRow(object, sizeof(object.before));
  for (std::size_t i = 0; i < kLanes; ++i) EXPECT_EQ(row[i], object.row[i]);
}

TEST(FloatRow, WhatIsMaskedOutIsNeitherAddedNorCounted) {
  const FloatRow not_finite{INFINITY, NAN, 1.0F, 2.0F};
  EXPECT_EQ(sumOf(where(IntRow{0, 0, -1, -1}, not_finite)), 3.0);
}

}  // namespace
}  // namespace slam::float_row_test
