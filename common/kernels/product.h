#pragma once

#include <cstddef>

#include "common/kernels/isa.h"

/// Matrix products and activations in float32, the same bits on every processor.
///
/// The rule, which is all that bits depend on: an element of a product is one chain of fused
/// multiply-adds (IEEE 754-2019, 5.4.1: one rounding) over the inner index, in its order, from its
/// start:
///   s_0 = start,   s_(k+1) = fma(left(r, k), right(k, c), s_k).
/// How rows and columns are cut into tiles, and how many numbers an instruction takes, is free.
namespace metronome::kernels {

/// Columns of a panel. The right side of a product lies in panels: [depth, kPanel] each.
inline constexpr std::size_t kPanel = 16;

constexpr std::size_t PanelsOf(std::size_t columns) { return (columns + kPanel - 1) / kPanel; }

/// out(r, c) = chain over k = 0 .. depth - 1 of left(r, k) * right(k, c).
///   left(r, k)  = left[r * left_row + k * left_step]
///   right(k, c) = right[c / kPanel * right_panel + k * right_step + c % kPanel]
///   out(r, c)   = out[r * out_row + c]
/// All of a panel is read on the right and all of a row up to a whole panel may be written to out,
/// whatever the number of columns.
struct Product {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::size_t depth = 0;
  const float* left = nullptr;
  std::size_t left_row = 0;
  std::size_t left_step = 1;
  const float* right = nullptr;
  std::size_t right_panel = 0;
  std::size_t right_step = kPanel;
  const float* start = nullptr;  // of the chains, [columns padded to panels]; none: zero
  float* out = nullptr;
  std::size_t out_row = 0;
  bool add = false;  // out += chain, one addition more
};

/// Thread-safe, as all below. By CurrentIsa(), or a given one.
void Multiply(const Product& product);
void Multiply(const Product& product, Isa isa);

/// Numbers of a matrix: `rows` rows of `columns`, padded to panels, which kernels read and write
/// too.
struct Block {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::size_t stride = 0;  // from row to row
};

/// values = tanh(values), within 6 ulp and never outside [-1, 1]; of an infinity +-1.
void Tanh(float* values, const Block& block);
void Tanh(float* values, const Block& block, Isa isa);

/// d = d * (1 - y * y), back through tanh, which gave y. Both have the block's stride.
void TimesTanhSlope(const float* y, float* d, const Block& block);
void TimesTanhSlope(const float* y, float* d, const Block& block, Isa isa);

/// values = exp(values), within 2 ulp for numbers from -87 to 87; those outside count as these.
void Exp(float* values, const Block& block);
void Exp(float* values, const Block& block, Isa isa);

}  // namespace metronome::kernels
