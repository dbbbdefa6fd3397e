#include "common/numbers/elementary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/numbers/random.h"
#include "tests/unit/support/bits_hash.h"

namespace metronome::numbers {
namespace {

constexpr int kArguments = 20000;  // a range
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kLeastNormal = std::numeric_limits<double>::min();
constexpr double kLeast = std::numeric_limits<double>::denorm_min();

using Function = double (*)(double);
using Reference = long double (*)(long double);

/// How far `got` is from `want`, in units of the last place of a double (of `digits` bits) there.
double Ulps(double got, long double want, int digits = 53, int least = -1074) {
  if (std::isnan(got) || std::isinf(got)) return kInfinity;
  int exponent = 0;
  std::frexp(want, &exponent);
  const long double ulp = std::ldexp(1.0L, std::max(exponent - digits, least));
  return static_cast<double>(std::abs(got - want) / ulp);
}

RandomStream Stream() { return {RandomPurpose::kCheck, 1, 2, 3}; }

double Between(double low, double high, RandomStream& random) {
  return low + (high - low) * random.Uniform();
}

double AnyFinite(RandomStream& random) {
  for (;;) {
    const auto number = std::bit_cast<double>(random.Bits());
    if (std::isfinite(number)) return number;
  }
}

double WorstBetween(Function function, Reference reference, double low, double high) {
  RandomStream random = Stream();
  double worst = 0;
  for (int i = 0; i < kArguments; ++i) {
    const double x = Between(low, high, random);
    worst = std::max(worst, Ulps(function(x), reference(x)));
  }
  return worst;
}

double WorstOfAnyPositive(Function function, Reference reference) {
  RandomStream random = Stream();
  double worst = 0;
  for (int i = 0; i < kArguments; ++i) {
    const double x = std::abs(AnyFinite(random));
    worst = std::max(worst, Ulps(function(x), reference(x)));
  }
  return worst;
}

void ExpectSame(double got, double want) {
  if (std::isnan(want)) {
    EXPECT_TRUE(std::isnan(got)) << got;
  } else {
    EXPECT_EQ(got, want);
    EXPECT_EQ(std::signbit(got), std::signbit(want));
  }
}

TEST(ElementaryTest, ExpIsWithinOneUlp) {
  EXPECT_LE(WorstBetween(Exp, std::exp, -1, 1), 1);
  EXPECT_LE(WorstBetween(Exp, std::exp, -745, 709.78), 1);
  EXPECT_LE(WorstBetween(Exp, std::exp, -745.2, -708), 1) << "subnormal results";
  EXPECT_LE(WorstBetween(Exp, std::exp, -kLeastNormal, kLeastNormal), 1);
}

TEST(ElementaryTest, ExpOfWhatHasNoFiniteResult) {
  const std::vector<std::pair<double, double>> cases = {{0.0, 1},        {-0.0, 1},
                                                        {kLeast, 1},     {kInfinity, kInfinity},
                                                        {-kInfinity, 0}, {kLargest, kInfinity},
                                                        {-kLargest, 0},  {710, kInfinity},
                                                        {-746, 0},       {kNaN, kNaN}};
  for (const auto& [x, want] : cases) {
    SCOPED_TRACE(x);
    ExpectSame(Exp(x), want);
  }
}

TEST(ElementaryTest, ExpOfFloatIsNearlyTheNearestFloat) {
  RandomStream random = Stream();
  double worst = 0;
  for (int i = 0; i < kArguments; ++i) {
    const auto x = static_cast<float>(Between(-104, 88.7, random));
    worst = std::max(worst, Ulps(double{Exp(x)}, std::exp(static_cast<long double>(x)), 24, -149));
  }
  EXPECT_LE(worst, 0.51);
  EXPECT_EQ(Exp(100.0F), std::numeric_limits<float>::infinity());
  EXPECT_EQ(Exp(-200.0F), 0.0F);
  EXPECT_TRUE(std::isnan(Exp(std::numeric_limits<float>::quiet_NaN())));
}

TEST(ElementaryTest, LogIsWithinOneUlp) {
  EXPECT_LE(WorstOfAnyPositive(Log, std::log), 1);
  EXPECT_LE(WorstBetween(Log, std::log, 0.5, 2), 1);
  EXPECT_LE(WorstBetween(Log, std::log, kLeast, kLeastNormal), 1) << "subnormal arguments";
}

TEST(ElementaryTest, LogOfTheEndsOfItsRange) {
  const std::vector<std::pair<double, double>> cases = {
      {0.0, -kInfinity}, {-0.0, -kInfinity}, {1, 0},       {kInfinity, kInfinity},
      {-1, kNaN},        {-kInfinity, kNaN}, {kNaN, kNaN}, {-kLeast, kNaN}};
  for (const auto& [x, want] : cases) {
    SCOPED_TRACE(x);
    ExpectSame(Log(x), want);
  }
}

struct Wave {
  Function ours;
  Reference reference;
};

class WaveTest : public ::testing::TestWithParam<Wave> {};

TEST_P(WaveTest, IsWithinOneUlp) {
  const auto& [ours, reference] = GetParam();
  EXPECT_LE(WorstBetween(ours, reference, -7, 7), 1);
  EXPECT_LE(WorstBetween(ours, reference, -1e6, 1e6), 1);
  EXPECT_LE(WorstBetween(ours, reference, 0.9e15, 1e15), 1);
  EXPECT_LE(WorstBetween(ours, reference, kLeast, kLeastNormal), 1) << "subnormal arguments";
  EXPECT_LE(WorstOfAnyPositive(ours, reference), 1);
}

TEST_P(WaveTest, HasNoValueAtInfinity) {
  for (const double x : {kInfinity, -kInfinity, kNaN}) EXPECT_TRUE(std::isnan(GetParam().ours(x)));
}

INSTANTIATE_TEST_SUITE_P(ElementaryTest, WaveTest,
                         ::testing::Values(Wave{Sin, std::sin}, Wave{Cos, std::cos}),
                         [](const auto& wave) { return wave.index == 0 ? "Sin" : "Cos"; });

TEST(ElementaryTest, SinAndCosOfZeros) {
  ExpectSame(Sin(0.0), 0.0);
  ExpectSame(Sin(-0.0), -0.0);
  ExpectSame(Cos(0.0), 1);
  ExpectSame(Cos(-0.0), 1);
}

double WorstPow(double least, double largest, double (*base)(RandomStream&)) {
  RandomStream random = Stream();
  double worst = 0;
  for (int i = 0; i < kArguments; ++i) {
    const double x = base(random);
    const double y = Between(least, largest, random) / std::log(x);
    worst = std::max(worst, Ulps(Pow(x, y), std::pow(static_cast<long double>(x), y)));
  }
  return worst;
}

TEST(ElementaryTest, PowIsWithinOneUlp) {
  const auto any = [](RandomStream& random) { return std::abs(AnyFinite(random)); };
  const auto near_one = [](RandomStream& random) { return Between(0.5, 2, random); };
  EXPECT_LE(WorstPow(-745, 709, any), 1);
  EXPECT_LE(WorstPow(-745, 709, near_one), 1);
  EXPECT_LE(WorstPow(-745, -708, any), 1) << "subnormal results";
  EXPECT_LE(WorstPow(-3, 3, near_one), 1);
  for (const double beta : {0.9, 0.999}) {  // as the corrections of Adam
    for (int t = 1; t < kArguments; ++t)
      ASSERT_LE(Ulps(Pow(beta, t), std::pow(static_cast<long double>(beta), t)), 1) << t;
  }
}

TEST(ElementaryTest, PowOfWhatAnnexFNames) {
  const std::vector<double> special = {0.0,  -0.0,   kInfinity, -kInfinity, kNaN,   1,
                                       -1,   2,      -2,        3,          -3,     2.5,
                                       -2.5, kLeast, -kLeast,   0x1p60,     -0x1p60};
  for (const double x : special) {
    for (const double y : special) {
      if (std::abs(y) == 2.5 && std::isfinite(x)) continue;  // not exact
      SCOPED_TRACE(::testing::Message() << x << " to the " << y);
      const auto exact = static_cast<double>(std::pow(static_cast<long double>(x), y));
      if (std::abs(exact) != 1.0 / 3 && std::abs(exact) != 1.0 / 27) ExpectSame(Pow(x, y), exact);
    }
  }
}

// Of another version of SLEEF, or another variant, a last bit would differ.
TEST(ElementaryTest, TheBitsAreFrozen) {
  RandomStream random = Stream();
  testing::BitsHash hash;
  for (int i = 0; i < kArguments; ++i) {
    const double x = Between(-10, 10, random);
    for (const double y : {Exp(x), Log(std::abs(x)), Sin(x), Cos(x), Pow(std::abs(x), x)})
      hash.Add(y);
  }
  EXPECT_EQ(hash.value(), 0x652841ebe8ce1605U);
}

}  // namespace
}  // namespace metronome::numbers
