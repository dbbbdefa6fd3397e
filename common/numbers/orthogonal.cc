#include "common/numbers/orthogonal.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace metronome::numbers {
namespace {

/// Vectors side by side: the columns of a row-major matrix. What is done to all of them at once is
/// done element by element, so that the compiler may use wide registers without another order of
/// sums.
struct Columns {
  std::size_t length, count;
  std::vector<double> numbers;  // [length, count]

  double& at(std::size_t i, std::size_t vector) { return numbers[i * count + vector]; }
};

void Normalise(Columns& vectors, std::size_t which) {
  double squares = 0;
  for (std::size_t i = 0; i < vectors.length; ++i)
    squares += vectors.at(i, which) * vectors.at(i, which);
  const double length = std::sqrt(squares);
  for (std::size_t i = 0; i < vectors.length; ++i) vectors.at(i, which) /= length;
}

/// Of all that follow `unit`, which has length 1.
void RemovePartsAlong(Columns& vectors, std::size_t unit) {
  std::vector<double> parts(vectors.count, 0.0);
  for (std::size_t i = 0; i < vectors.length; ++i) {
    const double number = vectors.at(i, unit);
    for (std::size_t v = unit + 1; v < vectors.count; ++v) parts[v] += number * vectors.at(i, v);
  }
  for (std::size_t i = 0; i < vectors.length; ++i) {
    const double number = vectors.at(i, unit);
    for (std::size_t v = unit + 1; v < vectors.count; ++v) vectors.at(i, v) -= number * parts[v];
  }
}

/// Gram-Schmidt, modified. Of nearly dependent vectors rounding leaves some part along each other;
/// a second time removes it (Giraud, Langou and Rozloznik, 2005).
void Orthonormalise(Columns& vectors) {
  for (int time = 0; time < 2; ++time) {
    for (std::size_t v = 0; v < vectors.count; ++v) {
      Normalise(vectors, v);
      RemovePartsAlong(vectors, v);
    }
  }
}

std::vector<double> Transposed(Columns& vectors) {
  std::vector<double> numbers;
  numbers.reserve(vectors.numbers.size());
  for (std::size_t v = 0; v < vectors.count; ++v) {
    for (std::size_t i = 0; i < vectors.length; ++i) numbers.push_back(vectors.at(i, v));
  }
  return numbers;
}

}  // namespace

std::vector<double> Orthogonal(std::int32_t rows, std::int32_t columns, RandomStream random) {
  Columns vectors{static_cast<std::size_t>(std::max(rows, columns)),
                  static_cast<std::size_t>(std::min(rows, columns)),
                  {}};
  vectors.numbers.resize(vectors.length * vectors.count);
  for (std::size_t v = 0; v < vectors.count; ++v) {
    for (std::size_t i = 0; i < vectors.length; ++i) vectors.at(i, v) = random.Normal();
  }
  // Each vector keeps a positive part along its normal numbers: no direction is preferred.
  Orthonormalise(vectors);
  return rows < columns ? Transposed(vectors) : vectors.numbers;
}

}  // namespace metronome::numbers
