// SPDX-License-Identifier: BSD-3-Clause
// Of the functions that slamd takes from glibc 2.36, hypot alone gives other bits on aarch64 (fused) than on amd64 with
// FMA (where it is not). Programs that link this file have amd64's: C. Borges, "An Improved Algorithm for hypot(a,b)",
// arXiv:1904.09481, the corrected, unfused variant, with glibc's limits.
#include <cmath>
#include <limits>

namespace {

/// @param a the greater one; neither squares out of range
double corrected(double a, double b) {
  const double h = std::sqrt(a * a + b * b);
  if (h <= 2.0 * b) {
    const double delta = h - b;
    return h - (a * (2.0 * delta - a) + (delta - 2.0 * (a - b)) * delta) / (2.0 * h);
  }
  const double delta = h - a;
  return h - (2.0 * delta * (a - 2.0 * b) + ((4.0 * delta - b) * b + delta * delta)) / (2.0 * h);
}

}  // namespace

extern "C" double hypot(double x, double y) noexcept {
  if (std::isinf(x) || std::isinf(y)) return std::numeric_limits<double>::infinity();
  if (std::isnan(x) || std::isnan(y)) return x + y;
  constexpr double kLarge = 0x1p+511, kTiny = 0x1p-459, kScale = 0x1p-600, kNothing = 0x1p-54;
  const double a = std::fmax(std::fabs(x), std::fabs(y)), b = std::fmin(std::fabs(x), std::fabs(y));
  if (b <= a * kNothing) return a + b;
  if (a > kLarge) return corrected(a * kScale, b * kScale) / kScale;
  if (b < kTiny) return corrected(a / kScale, b / kScale) * kScale;
  return corrected(a, b);
}
