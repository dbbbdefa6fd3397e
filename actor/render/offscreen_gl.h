#pragma once

#include <stdexcept>
#include <vector>

namespace metronome::render {

/// OpenGL cannot be had; what() says what to install.
class GraphicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An OpenGL context of the software renderer OSMesa: no display, no GPU. It is current on the
/// thread that made it until its end; MuJoCo finds its functions by itself on both engines, since
/// the library is loaded for all to see. Loaded only here: it brings a compiler (LLVM) along, which
/// an actor that plays episodes has no use for.
class OffscreenGl {
 public:
  /// @throws GraphicsError if the library is missing or gives no context.
  OffscreenGl();
  ~OffscreenGl();
  OffscreenGl(const OffscreenGl&) = delete;
  OffscreenGl& operator=(const OffscreenGl&) = delete;

 private:
  void (*destroy_)(void* context);
  void* context_;
  std::vector<unsigned char> window_;  // OSMesa wants one; MuJoCo draws into a buffer of its own
};

}  // namespace metronome::render
