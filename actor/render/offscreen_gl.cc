#include "actor/render/offscreen_gl.h"

#include <dlfcn.h>

#include <string>

namespace metronome::render {
namespace {

constexpr const char* kLibrary = "libOSMesa.so.8";

// From GL/gl.h and GL/osmesa.h, whose packages bring half of X11.
constexpr unsigned kRgba = 0x1908;
constexpr unsigned kUnsignedByte = 0x1401;
constexpr int kDepthBits = 24;
constexpr int kStencilBits = 8;
constexpr int kWindow = 16;  // pixels a side
using CreateContext = void* (*)(unsigned format, int depth, int stencil, int accum, void* shared);
using MakeCurrent = unsigned char (*)(void* context, void* buffer, unsigned type, int width,
                                      int height);
using DestroyContext = void (*)(void* context);

/// For the life of the process: MuJoCo keeps pointers into it.
void* Library() {
  static void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_GLOBAL);
  if (library == nullptr) {
    throw GraphicsError(
        std::string("drawing needs ") + kLibrary +
        ", which cannot be loaded; install Debian's package libosmesa6 (deploy/setup "
        "does)");
  }
  return library;
}

template <typename Function>
Function Find(const char* name) {
  void* const found = dlsym(Library(), name);
  if (found == nullptr) throw GraphicsError(std::string(kLibrary) + " has no " + name);
  return reinterpret_cast<Function>(found);
}

}  // namespace

OffscreenGl::OffscreenGl()
    : destroy_(Find<DestroyContext>("OSMesaDestroyContext")),
      context_(Find<CreateContext>("OSMesaCreateContextExt")(kRgba, kDepthBits, kStencilBits, 0,
                                                             nullptr)),
      window_(std::size_t{kWindow} * kWindow * 4) {
  if (context_ == nullptr) throw GraphicsError("OSMesa gives no OpenGL context");
  if (Find<MakeCurrent>("OSMesaMakeCurrent")(context_, window_.data(), kUnsignedByte, kWindow,
                                             kWindow) == 0) {
    destroy_(context_);
    throw GraphicsError("OSMesa's OpenGL context cannot be made current");
  }
}

OffscreenGl::~OffscreenGl() { destroy_(context_); }

}  // namespace metronome::render
