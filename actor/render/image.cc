#include "actor/render/image.h"

#include <lodepng.h>

#include <stdexcept>
#include <string_view>

#include "common/process/files.h"

namespace metronome::render {

void WritePng(const std::string& path, const Image& image) {
  std::vector<unsigned char> png;
  const unsigned error = lodepng::encode(png, image.rgb, static_cast<unsigned>(image.size.width),
                                         static_cast<unsigned>(image.size.height), LCT_RGB, 8);
  if (error != 0) {
    throw std::runtime_error("cannot encode " + path + ": " + lodepng_error_text(error));
  }
  process::WriteFileAtomically(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace metronome::render
