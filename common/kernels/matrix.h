#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace metronome::kernels {

/// Rows of float32 numbers for the kernels: each begins at a multiple of 64 bytes and is padded
/// with at least so many numbers that a kernel may write whole panels (product.h). Padding is zero
/// until a kernel writes there.
class Matrix {
 public:
  Matrix() = default;
  Matrix(std::size_t rows, std::size_t columns) { Resize(rows, columns); }

  /// All numbers are zero afterwards, if the shape is another one; else nothing changes.
  void Resize(std::size_t rows, std::size_t columns);

  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] std::size_t stride() const { return stride_; }  // from row to row
  [[nodiscard]] float* row(std::size_t i) { return data_.get() + i * stride_; }
  [[nodiscard]] const float* row(std::size_t i) const { return data_.get() + i * stride_; }
  [[nodiscard]] float* data() { return data_.get(); }
  [[nodiscard]] const float* data() const { return data_.get(); }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(float* numbers) const { ::operator delete[](numbers, kAlignment); }
  };

  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
  std::size_t stride_ = 0;
  std::unique_ptr<float[], Free> data_;
};

}  // namespace metronome::kernels
