// SPDX-License-Identifier: BSD-3-Clause
// What slamd computes with, from the compiler, from glibc and from Eigen, gives the same bits on amd64 and arm64.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace slam::same_bits_test {
namespace {

constexpr int kDraws = 200'000;

/// Of all bits of all numbers, in order (FNV-1a by words).
class Sum {
 public:
  void add(double number) { sum_ = (sum_ ^ std::bit_cast<std::uint64_t>(number)) * 1099511628211U; }
  std::uint64_t value() const { return sum_; }

 private:
  std::uint64_t sum_ = 14695981039346656037U;
};

/// The standard's distributions are not the same everywhere.
double draw(std::mt19937_64& generator, double low, double high) {
  return low + (high - low) * (static_cast<double>(generator() >> 11) * 0x1p-53);
}

template <typename Function>
std::uint64_t sumOf(double low, double high, Function&& function) {
  std::mt19937_64 generator(7);
  Sum sum;
  for (int i = 0; i < kDraws; ++i) {
    const double a = draw(generator, low, high), b = draw(generator, low, high);
    sum.add(function(a, b));
  }
  return sum.value();
}

class SameBits : public testing::Test {
 protected:
  void SetUp() override {
#ifdef __x86_64__
    if (!__builtin_cpu_supports("fma") || !__builtin_cpu_supports("avx2"))
      GTEST_SKIP() << "glibc takes other variants on a processor without FMA";
#endif
  }
};

TEST_F(SameBits, OfAngles) {
  EXPECT_EQ(sumOf(-7.0, 7.0, [](double a, double) { return std::sin(a); }), 5287122129623528617U);
  EXPECT_EQ(sumOf(-7.0, 7.0, [](double a, double) { return std::cos(a); }), 17808772670578355617U);
  EXPECT_EQ(sumOf(-0.1, 0.1, [](double a, double) { return std::sin(a) + std::cos(a); }), 9746749560614100540U);
  EXPECT_EQ(sumOf(-1.5, 1.5, [](double a, double) { return std::tan(a); }), 17979027944232364791U);
  EXPECT_EQ(sumOf(-1.0, 1.0, [](double a, double) { return std::acos(a); }), 453957088347028349U);
  EXPECT_EQ(sumOf(-30.0, 30.0, [](double a, double b) { return std::atan2(a, b); }), 14491030387832340098U);
  EXPECT_EQ(sumOf(-30.0, 30.0, [](double a, double b) { return std::remainder(a, b); }), 6099641647436070403U);
}

TEST_F(SameBits, OfPowers) {
  EXPECT_EQ(sumOf(-30.0, 10.0, [](double a, double) { return std::exp(a); }), 13928458843513721842U);
  EXPECT_EQ(sumOf(-10.0, 1.0, [](double a, double) { return std::exp(static_cast<float>(a)); }), 7529364161157499941U);
  EXPECT_EQ(sumOf(1e-9, 100.0, [](double a, double) { return std::log(a); }), 7977874770246486921U);
  EXPECT_EQ(sumOf(-0.9, 10.0, [](double a, double) { return std::log1p(a); }), 17701088465713597635U);
  EXPECT_EQ(sumOf(1e-9, 100.0, [](double a, double) { return std::log2(a); }), 4017971414266993152U);
  EXPECT_EQ(sumOf(0.0, 10.0, [](double a, double b) { return std::pow(a, b); }), 11926434018198585817U);
  EXPECT_EQ(sumOf(-20.0, 20.0, [](double a, double) { return std::exp2(std::round(a)); }),
            8340582716996684837U);  // decay_field.cpp
}

TEST_F(SameBits, OfLengths) {
  const auto hypotenuse = [](double a, double b) { return std::hypot(a, b); };
  EXPECT_EQ(sumOf(-30.0, 30.0, hypotenuse), 13400878677993594727U);
  EXPECT_EQ(sumOf(-1e-3, 1e-3, hypotenuse), 15052822964074714148U);
  EXPECT_EQ(sumOf(0.0, 60.0, [](double a, double b) { return std::hypot(static_cast<int>(a), static_cast<int>(b)); }),
            7538441471834198387U);
  // Lengths of all sizes, beside each other.
  EXPECT_EQ(sumOf(-700.0, 700.0, [](double a, double b) { return std::hypot(std::exp(a), std::exp(0.1 * b + a)); }),
            11264633920347412173U);
  EXPECT_EQ(sumOf(-700.0, 700.0, [](double a, double b) { return std::hypot(std::exp(a), std::exp(b)); }),
            13828618624208134250U);
  constexpr double kInfinity = std::numeric_limits<double>::infinity(),
                   kNone = std::numeric_limits<double>::quiet_NaN();
  const volatile double zero = 0.0;
  EXPECT_EQ(std::hypot(zero, -0.0), 0.0);
  EXPECT_EQ(std::hypot(zero, -kInfinity), kInfinity);
  EXPECT_EQ(std::hypot(kNone + zero, kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(std::hypot(kNone + zero, 1.0)));
}

TEST_F(SameBits, OfSumsOfProducts) {
  EXPECT_EQ(sumOf(-3.0, 3.0, [](double a, double b) { return a * b + a; }), 4664732516049113557U)
      << "the compiler fuses";
}

TEST_F(SameBits, OfMatrices) {
  using Matrix = Eigen::Matrix<double, 7, 7>;
  std::mt19937_64 generator(7);
  Sum sum;
  Matrix P = Matrix::Identity();
  for (int i = 0; i < 2000; ++i) {  // a filter's prediction and correction
    Matrix F = Matrix::Identity();
    Eigen::Matrix<double, 3, 7> H;
    for (double& element : F.reshaped()) element += draw(generator, -0.1, 0.1);
    for (double& element : H.reshaped()) element = draw(generator, -1.0, 1.0);
    P = F * P * F.transpose() + 0.01 * Matrix::Identity();
    const Eigen::Matrix3d S = H * P * H.transpose() + Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 7, 3> K = S.llt().solve(H * P).transpose();
    P -= K * S * K.transpose();
    P = (0.5 * (P + P.transpose())).eval();
    sum.add(S.llt().matrixLLT()(2, 0));
    for (const double element : P.reshaped()) sum.add(element);
  }
  EXPECT_TRUE(P.allFinite());
  EXPECT_EQ(sum.value(), 12565993982907044066U);
}

}  // namespace
}  // namespace slam::same_bits_test
