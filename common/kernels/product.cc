#include "common/kernels/product.h"

#include "common/kernels/targets.h"
// foreach_target.h includes this file once for each of them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/kernels/product.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include <cmath>

#include "common/kernels/kernel_table.h"

HWY_BEFORE_NAMESPACE();
namespace metronome::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kPanel>;
using Vector = hn::Vec<Tag>;
constexpr std::size_t kLanes = HWY_TARGET == HWY_SCALAR ? 1 : HWY_MAX_BYTES / sizeof(float);
constexpr std::size_t kVectors = kPanel / kLanes;  // of a panel

// One rounding. Highway's scalar multiplication and addition makes two.
HWY_INLINE Vector Fma(Vector a, Vector b, Vector c) {
#if HWY_TARGET == HWY_SCALAR
  return Vector(std::fma(a.raw, b.raw, c.raw));
#else
  return hn::MulAdd(a, b, c);
#endif
}

// `Rows` rows by `Width` vectors of `out` from `vector` on, whose chains stay in registers.
template <std::size_t Rows, std::size_t Width>
HWY_INLINE void Tile(const Product& p, std::size_t row, std::size_t vector) {
  const Tag tag;
  const std::size_t column = vector * kLanes;
  const float* HWY_RESTRICT left = p.left + row * p.left_row;
  const float* HWY_RESTRICT right[Width];
  Vector sum[Rows][Width];
#pragma GCC unroll 16
  for (std::size_t w = 0; w < Width; ++w) {
    right[w] = p.right + (vector + w) / kVectors * p.right_panel + (vector + w) % kVectors * kLanes;
    const Vector start = p.start ? hn::LoadU(tag, p.start + column + w * kLanes) : hn::Zero(tag);
#pragma GCC unroll 16
    for (std::size_t r = 0; r < Rows; ++r) sum[r][w] = start;
  }
  for (std::size_t k = 0; k < p.depth; ++k) {
    Vector b[Width];
#pragma GCC unroll 16
    for (std::size_t w = 0; w < Width; ++w) b[w] = hn::LoadU(tag, right[w] + k * p.right_step);
#pragma GCC unroll 16
    for (std::size_t r = 0; r < Rows; ++r) {
      const Vector a = hn::Set(tag, left[r * p.left_row + k * p.left_step]);
#pragma GCC unroll 16
      for (std::size_t w = 0; w < Width; ++w) sum[r][w] = Fma(a, b[w], sum[r][w]);
    }
  }
#pragma GCC unroll 16
  for (std::size_t r = 0; r < Rows; ++r) {
    float* out = p.out + (row + r) * p.out_row + column;
#pragma GCC unroll 16
    for (std::size_t w = 0; w < Width; ++w, out += kLanes) {
      const Vector chain = p.add ? hn::Add(hn::LoadU(tag, out), sum[r][w]) : sum[r][w];
      hn::StoreU(chain, tag, out);
    }
  }
}

// A tile of `rows` rows, at most Rows.
template <std::size_t Rows, std::size_t Width>
HWY_INLINE void TileOf(const Product& p, std::size_t rows, std::size_t row, std::size_t vector) {
  if constexpr (Rows > 1) {
    if (rows < Rows) return TileOf<Rows - 1, Width>(p, rows, row, vector);
  }
  Tile<Rows, Width>(p, row, vector);
}

// Down all rows in as few tiles as go, as even as go: small ones cannot hide their latency.
template <std::size_t Rows, std::size_t Width>
HWY_INLINE void Column(const Product& p, std::size_t vector) {
  std::size_t row = 0;
  for (std::size_t tiles = (p.rows + Rows - 1) / Rows; tiles > 0; --tiles) {
    const std::size_t rows = (p.rows - row + tiles - 1) / tiles;
    TileOf<Rows, Width>(p, rows, row, vector);
    row += rows;
  }
}

// The widest tiles first; what is left of the columns by narrower ones, the last by taller ones.
template <std::size_t Rows, std::size_t Width>
HWY_INLINE void Columns(const Product& p, std::size_t vectors, std::size_t vector = 0) {
  for (; vector + Width <= vectors; vector += Width) {
    Column<Width == 1 ? 2 * Rows : Rows, Width>(p, vector);
  }
  if constexpr (Width > 1) {
    if (vector < vectors) Columns<Rows, Width / 2>(p, vectors, vector);
  }
}

void MultiplyHere(const Product& p) {
  const std::size_t vectors = (p.columns + kLanes - 1) / kLanes;
  // Enough chains at once to hide the latency of an addition, and no more than registers hold: 16
  // vectors with AVX2, 32 with AVX-512.
  constexpr std::size_t kWide = HWY_TARGET == HWY_AVX3 ? 4 : HWY_TARGET == HWY_AVX2 ? 2 : 16;
  if (p.rows == 1) {
    Columns<1, 8>(p, vectors);
  } else if (p.rows < 4) {
    Columns<3, 4>(p, vectors);
  } else {
    Columns<HWY_TARGET == HWY_SCALAR ? 1 : 6, kWide>(p, vectors);
  }
}

// To [-bound, bound]; a NaN stays one. Instructions give the second operand then, Highway's scalar
// functions the other one.
HWY_INLINE Vector Clamp(Vector x, float bound) {
#if HWY_TARGET == HWY_SCALAR
  return Vector(x.raw < -bound ? -bound : x.raw > bound ? bound : x.raw);
#else
  const Tag tag;
  return hn::Min(hn::Set(tag, bound), hn::Max(hn::Set(tag, -bound), x));
#endif
}

// x P(x^2) / Q(x^2), fitted to the least relative error on [0, 9], 0.35 of half an ulp; roundings
// add what is above that, and may pass 1. Beyond, tanh is within an ulp of what it is at 9.
HWY_INLINE Vector TanhOf(Vector x) {
  const Tag tag;
  x = Clamp(x, 9);
  const Vector u = hn::Mul(x, x);
  Vector p = hn::Set(tag, 1.335460191e-08F);
  p = Fma(p, u, hn::Set(tag, 2.060903658e-05F));
  p = Fma(p, u, hn::Set(tag, 3.495585247e-03F));
  p = Fma(p, u, hn::Set(tag, 1.338102320e-01F));
  p = Fma(p, u, hn::Set(tag, 1.0F));
  Vector q = hn::Set(tag, 7.776533098e-07F);
  q = Fma(q, u, hn::Set(tag, 3.285630172e-04F));
  q = Fma(q, u, hn::Set(tag, 2.587697118e-02F));
  q = Fma(q, u, hn::Set(tag, 4.671433881e-01F));
  q = Fma(q, u, hn::Set(tag, 1.0F));
  return Clamp(hn::Div(hn::Mul(x, p), q), 1);
}

void TanhHere(float* values, const Block& block) {
  const Tag tag;
  const std::size_t padded = PanelsOf(block.columns) * kPanel;
  for (std::size_t r = 0; r < block.rows; ++r, values += block.stride) {
    for (std::size_t i = 0; i < padded; i += kLanes) {
      hn::StoreU(TanhOf(hn::LoadU(tag, values + i)), tag, values + i);
    }
  }
}

void TimesTanhSlopeHere(const float* y, float* d, const Block& block) {
  const Tag tag;
  const Vector one = hn::Set(tag, 1.0F);
  const std::size_t padded = PanelsOf(block.columns) * kPanel;
  for (std::size_t r = 0; r < block.rows; ++r, y += block.stride, d += block.stride) {
    for (std::size_t i = 0; i < padded; i += kLanes) {
      const Vector value = hn::LoadU(tag, y + i);
      const Vector slope = hn::Sub(one, hn::Mul(value, value));
      hn::StoreU(hn::Mul(hn::LoadU(tag, d + i), slope), tag, d + i);
    }
  }
}

// 2^n (1 + r + r^2 P(r)), r = x - n ln 2 in [-ln 2 / 2, ln 2 / 2]. Constants: expf of the Cephes
// library (Moshier, netlib.org/cephes).
HWY_INLINE Vector ExpOf(Vector x) {
  const Tag tag;
  const hn::RebindToSigned<Tag> integers;
  x = Clamp(x, 87);                                // 2^n and the result are normal numbers
  const Vector magic = hn::Set(tag, 12582912.0F);  // 1.5 * 2^23: added, it rounds to an integer
  const Vector n = hn::Sub(Fma(x, hn::Set(tag, 1.44269504F), magic), magic);
  Vector r = Fma(n, hn::Set(tag, -0.693359375F), x);
  r = Fma(n, hn::Set(tag, 2.12194440e-4F), r);
  Vector p = hn::Set(tag, 1.9875691500e-4F);
  p = Fma(p, r, hn::Set(tag, 1.3981999507e-3F));
  p = Fma(p, r, hn::Set(tag, 8.3334519073e-3F));
  p = Fma(p, r, hn::Set(tag, 4.1665795894e-2F));
  p = Fma(p, r, hn::Set(tag, 1.6666665459e-1F));
  p = Fma(p, r, hn::Set(tag, 5.0000001201e-1F));
  p = hn::Add(Fma(p, hn::Mul(r, r), r), hn::Set(tag, 1.0F));
  const auto exponent = hn::Add(hn::ConvertTo(integers, n), hn::Set(integers, 127));
  return hn::Mul(p, hn::BitCast(tag, hn::ShiftLeft<23>(exponent)));
}

void ExpHere(float* values, const Block& block) {
  const Tag tag;
  const std::size_t padded = PanelsOf(block.columns) * kPanel;
  for (std::size_t r = 0; r < block.rows; ++r, values += block.stride) {
    for (std::size_t i = 0; i < padded; i += kLanes) {
      hn::StoreU(ExpOf(hn::LoadU(tag, values + i)), tag, values + i);
    }
  }
}

}  // namespace

KernelTable Table() { return {&MultiplyHere, &TanhHere, &TimesTanhSlopeHere, &ExpHere}; }

}  // namespace HWY_NAMESPACE
}  // namespace metronome::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace metronome::kernels {
namespace {

const KernelTable& TableOf(Isa isa) {
  static const KernelTable tables[] = {N_SCALAR::Table(), N_AVX2::Table(), N_AVX3::Table()};
  return tables[static_cast<std::size_t>(isa)];
}

}  // namespace

void Multiply(const Product& product, Isa isa) { TableOf(isa).multiply(product); }
void Multiply(const Product& product) { Multiply(product, CurrentIsa()); }

void Tanh(float* values, const Block& block, Isa isa) { TableOf(isa).tanh(values, block); }
void Tanh(float* values, const Block& block) { Tanh(values, block, CurrentIsa()); }

void TimesTanhSlope(const float* y, float* d, const Block& block, Isa isa) {
  TableOf(isa).times_tanh_slope(y, d, block);
}
void TimesTanhSlope(const float* y, float* d, const Block& block) {
  TimesTanhSlope(y, d, block, CurrentIsa());
}

void Exp(float* values, const Block& block, Isa isa) { TableOf(isa).exp(values, block); }
void Exp(float* values, const Block& block) { Exp(values, block, CurrentIsa()); }

}  // namespace metronome::kernels
#endif  // HWY_ONCE
