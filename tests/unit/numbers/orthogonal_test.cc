#include "common/numbers/orthogonal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/unit/support/bits_hash.h"

namespace metronome::numbers {
namespace {

RandomStream Stream(std::uint64_t number) { return {RandomPurpose::kInitialise, 1, number, 0}; }

/// The largest difference between the identity and the products of all rows (columns, if fewer).
double Deviation(const std::vector<double>& matrix, std::size_t rows, std::size_t columns) {
  const bool wide = rows <= columns;
  const std::size_t vectors = std::min(rows, columns);
  const std::size_t length = std::max(rows, columns);
  const auto at = [&](std::size_t vector, std::size_t i) {
    return matrix[wide ? vector * columns + i : i * columns + vector];
  };
  double worst = 0;
  for (std::size_t a = 0; a < vectors; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double product = a == b ? -1 : 0;
      for (std::size_t i = 0; i < length; ++i) product += at(a, i) * at(b, i);
      worst = std::max(worst, std::abs(product));
    }
  }
  return worst;
}

TEST(OrthogonalTest, RowsOrColumnsAreOrthonormal) {
  for (const auto& [rows, columns] :
       {std::pair{128, 39}, {39, 128}, {128, 128}, {4, 128}, {1, 7}, {5, 1}}) {
    const std::vector<double> matrix = Orthogonal(rows, columns, Stream(0));
    ASSERT_EQ(matrix.size(), std::size_t(rows) * std::size_t(columns));
    EXPECT_LT(Deviation(matrix, std::size_t(rows), std::size_t(columns)), 1e-12)
        << rows << " x " << columns;
  }
}

// As many as are square: the less likely ones, with nearly dependent vectors, are among them.
TEST(OrthogonalTest, NearlyDependentVectorsAreOrthonormalToo) {
  double worst = 0;
  for (std::uint64_t number = 0; number < 20000; ++number)
    worst = std::max(worst, Deviation(Orthogonal(3, 3, Stream(number)), 3, 3));
  EXPECT_LT(worst, 1e-14);
}

// Of two by two: the first row's angle is uniform, and the second row is on either side alike.
TEST(OrthogonalTest, NoDirectionIsPreferred) {
  constexpr int kMatrices = 20000;
  int quadrant = 0;
  int left = 0;
  for (std::uint64_t number = 0; number < kMatrices; ++number) {
    const std::vector<double> m = Orthogonal(2, 2, Stream(number));
    quadrant += m[0] > 0 && m[1] > 0 ? 1 : 0;
    left += m[0] * m[3] - m[1] * m[2] > 0 ? 1 : 0;
  }
  EXPECT_NEAR(quadrant, 0.25 * kMatrices, 300);
  EXPECT_NEAR(left, 0.5 * kMatrices, 350);
}

// Vectors keep a positive part along the normal numbers that they were: R's diagonal is positive.
TEST(OrthogonalTest, TheFirstVectorIsItsNormalNumbersToLengthOne) {
  const std::vector<double> matrix = Orthogonal(2, 3, Stream(5));
  RandomStream random = Stream(5);
  const double x = random.Normal();
  const double y = random.Normal();
  const double z = random.Normal();
  const double length = std::sqrt(x * x + y * y + z * z);
  EXPECT_DOUBLE_EQ(matrix[0], x / length);
  EXPECT_DOUBLE_EQ(matrix[1], y / length);
  EXPECT_DOUBLE_EQ(matrix[2], z / length);
}

// Doubles, because float32 hides nearly every other order of sums.
TEST(OrthogonalTest, TheBitsAreFrozen) {
  testing::BitsHash hash;
  for (const auto& [rows, columns] : {std::pair{64, 39}, {64, 64}, {4, 64}}) {
    for (const double number : Orthogonal(rows, columns, Stream(0))) hash.Add(number);
  }
  EXPECT_EQ(hash.value(), 0x070ee7326901ea7eU);
}

}  // namespace
}  // namespace metronome::numbers
