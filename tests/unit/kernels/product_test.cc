#include "common/kernels/product.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "common/kernels/matrix.h"
#include "common/numbers/random.h"

namespace metronome::kernels {
namespace {

void Fill(Matrix& matrix, numbers::RandomStream& random) {
  for (std::size_t r = 0; r < matrix.rows(); ++r) {
    for (std::size_t c = 0; c < matrix.columns(); ++c) matrix.row(r)[c] = float(random.Normal());
  }
}

/// One instruction set, by its name.
class KernelTest : public ::testing::TestWithParam<Isa> {
 protected:
  numbers::RandomStream random_{numbers::RandomPurpose::kEvaluate, 7, 7, 7};
};

struct Shape {
  std::size_t rows, columns, depth;
};

// Every remainder of a tile's rows and columns; odd depths, and none.
std::vector<Shape> Shapes() {
  std::vector<Shape> shapes;
  for (const std::size_t rows : {1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 24}) {
    for (const std::size_t columns : {1, 4, 8, 9, 16, 17, 31, 33, 64, 101, 130}) {
      shapes.push_back({rows, columns, (rows * 7 + columns) % 45});
    }
  }
  return shapes;
}

// The rule of product.h, written plainly.
float ByRule(const Matrix& left, const Matrix& right, const float* start, float out, bool add,
             std::size_t r, std::size_t c) {
  float chain = start == nullptr ? 0 : start[c];
  for (std::size_t k = 0; k < right.rows(); ++k) {
    chain = std::fma(left.row(r)[k], right.row(k)[c], chain);
  }
  return add ? out + chain : chain;
}

TEST_P(KernelTest, AProductIsOneChainAnElement) {
  for (const Shape& shape : Shapes()) {
    for (const bool add : {false, true}) {
      for (const bool with_start : {false, true}) {
        Matrix left(shape.rows, shape.depth), right(shape.depth, shape.columns);
        Matrix start(1, shape.columns), out(shape.rows, shape.columns);
        for (Matrix* matrix : {&left, &right, &start, &out}) Fill(*matrix, random_);
        Product product;
        product.rows = shape.rows;
        product.columns = shape.columns;
        product.depth = shape.depth;
        product.left = left.data();
        product.left_row = left.stride();
        product.right = right.data();
        product.right_panel = kPanel;
        product.right_step = right.stride();
        product.start = with_start ? start.data() : nullptr;
        product.out = out.data();
        product.out_row = out.stride();
        product.add = add;
        std::vector<float> want;
        for (std::size_t r = 0; r < shape.rows; ++r) {
          for (std::size_t c = 0; c < shape.columns; ++c) {
            want.push_back(ByRule(left, right, product.start, out.row(r)[c], add, r, c));
          }
        }
        Multiply(product, GetParam());
        for (std::size_t i = 0; i < want.size(); ++i) {
          ASSERT_EQ(out.row(i / shape.columns)[i % shape.columns], want[i])
              << shape.rows << " x " << shape.columns << " x " << shape.depth << ", element " << i;
        }
      }
    }
  }
}

// left may lie the other way, and right in panels that are packed.
TEST_P(KernelTest, StridesAreFree) {
  constexpr std::size_t kRows = 11, kColumns = 40, kDepth = 23;
  Matrix left(kDepth, kRows), right(kDepth, kColumns), out(kRows, kColumns);
  Fill(left, random_);
  Fill(right, random_);
  Matrix panels(PanelsOf(kColumns), kDepth * kPanel);
  for (std::size_t c = 0; c < kColumns; ++c) {
    for (std::size_t k = 0; k < kDepth; ++k) {
      panels.row(c / kPanel)[k * kPanel + c % kPanel] = right.row(k)[c];
    }
  }
  Product product;
  product.rows = kRows;
  product.columns = kColumns;
  product.depth = kDepth;
  product.left = left.data();
  product.left_row = 1;
  product.left_step = left.stride();
  product.right = panels.data();
  product.right_panel = panels.stride();
  product.out = out.data();
  product.out_row = out.stride();
  Multiply(product, GetParam());
  for (std::size_t r = 0; r < kRows; ++r) {
    for (std::size_t c = 0; c < kColumns; ++c) {
      float chain = 0;
      for (std::size_t k = 0; k < kDepth; ++k) {
        chain = std::fma(left.row(k)[r], right.row(k)[c], chain);
      }
      ASSERT_EQ(out.row(r)[c], chain) << r << ", " << c;
    }
  }
}

/// Of every 997th float of one sign.
std::vector<float> Floats() {
  std::vector<float> floats;
  for (std::uint32_t bits = 0; bits <= 0x7f800000U; bits += 997) {
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    floats.push_back(value);
  }
  floats.push_back(std::numeric_limits<float>::infinity());
  floats.resize((floats.size() + kPanel - 1) / kPanel * kPanel, 0);
  return floats;
}

TEST_P(KernelTest, TanhIsWithinSixUlpOverAllFloatsOddAndNeverAboveOne) {
  const std::vector<float> x = Floats();
  std::vector<float> plus = x;
  std::vector<float> minus(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) minus[i] = -x[i];
  Tanh(plus.data(), {1, plus.size(), plus.size()}, GetParam());
  Tanh(minus.data(), {1, minus.size(), minus.size()}, GetParam());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double want = std::tanh(double{x[i]});
    const float ulp = std::nextafter(float(want), 2.0F) - float(want);
    ASSERT_NEAR(plus[i], want, 6 * double{ulp}) << x[i];
    ASSERT_LE(plus[i], 1) << x[i];
    ASSERT_EQ(minus[i], -plus[i]) << x[i];
  }
  std::vector<float> odd(kPanel, std::numeric_limits<float>::quiet_NaN());
  Tanh(odd.data(), {1, kPanel, kPanel}, GetParam());
  for (const float value : odd) EXPECT_TRUE(std::isnan(value));
}

TEST_P(KernelTest, ExpIsWithinTwoUlpFromMinusToPlus87AndFlatBeyond) {
  std::vector<float> x;
  for (int i = -200000; i <= 200000; ++i) x.push_back(float(i) * 4.5e-4F);
  x.resize((x.size() + kPanel - 1) / kPanel * kPanel, 0);
  std::vector<float> y = x;
  Exp(y.data(), {1, y.size(), y.size()}, GetParam());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double want = std::exp(std::clamp(double{x[i]}, -87.0, 87.0));
    const float ulp = std::nextafter(float(want), INFINITY) - float(want);
    ASSERT_NEAR(y[i], want, 2 * double{ulp}) << x[i];
  }
}

TEST_P(KernelTest, ElementwiseKernelsGiveTheBitsOfTheScalarOnes) {
  Matrix x(5, 50), y(5, 50), d(5, 50), want(5, 50), before(5, 50);
  Matrix exp(5, 50), exp_want(5, 50);
  Fill(x, random_);
  Fill(d, random_);
  for (std::size_t r = 0; r < 5; ++r) {
    std::copy_n(x.row(r), 50, y.row(r));
    std::copy_n(d.row(r), 50, want.row(r));
    std::copy_n(d.row(r), 50, before.row(r));
    for (std::size_t c = 0; c < 50; ++c) exp.row(r)[c] = exp_want.row(r)[c] = 20 * x.row(r)[c];
  }
  const Block block{5, 50, x.stride()};
  Tanh(x.data(), block, Isa::kScalar);
  Tanh(y.data(), block, GetParam());
  TimesTanhSlope(x.data(), want.data(), block, Isa::kScalar);
  TimesTanhSlope(y.data(), d.data(), block, GetParam());
  Exp(exp_want.data(), block, Isa::kScalar);
  Exp(exp.data(), block, GetParam());
  for (std::size_t r = 0; r < 5; ++r) {
    for (std::size_t c = 0; c < 50; ++c) {
      ASSERT_EQ(y.row(r)[c], x.row(r)[c]);
      ASSERT_EQ(d.row(r)[c], want.row(r)[c]);
      ASSERT_EQ(exp.row(r)[c], exp_want.row(r)[c]);
      const float slope = 1 - x.row(r)[c] * x.row(r)[c];
      ASSERT_EQ(want.row(r)[c], before.row(r)[c] * slope);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Isas, KernelTest, ::testing::ValuesIn(SupportedIsas()),
                         [](const auto& of) { return std::string(NameOf(of.param)); });

TEST(MatrixTest, RowsAreAlignedAndPaddedToWholePanelsOfZeros) {
  for (const std::size_t columns : {1, 15, 16, 17, 64, 128, 256}) {
    const Matrix matrix(3, columns);
    EXPECT_GE(matrix.stride(), PanelsOf(columns) * kPanel);
    EXPECT_NE(matrix.stride() % 64, 0U) << "rows of a tile share sets of the cache";
    for (std::size_t r = 0; r < 3; ++r) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(matrix.row(r)) % 64, 0U);
      for (std::size_t c = 0; c < matrix.stride(); ++c) EXPECT_EQ(matrix.row(r)[c], 0);
    }
  }
}

}  // namespace
}  // namespace metronome::kernels
