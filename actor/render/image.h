#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace metronome::render {

struct ImageSize {
  int width = 0;
  int height = 0;
};

/// Colours, 8 bits a channel.
struct Image {
  ImageSize size;
  std::vector<std::uint8_t> rgb;  // [height, width, 3], top row first
};

/// Writes a PNG file, whole or not at all.
/// @throws std::runtime_error (std::system_error where the file system says no), naming the path.
void WritePng(const std::string& path, const Image& image);

}  // namespace metronome::render
