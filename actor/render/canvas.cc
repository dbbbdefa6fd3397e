#include "actor/render/canvas.h"

namespace metronome::render {
namespace {

float Share(std::uint8_t channel) { return static_cast<float>(channel) / 255; }

}  // namespace

void Canvas::Fill(const mjrRect& area, const Color& color, double opacity) const {
  mjr_rectangle(area, Share(color[0]), Share(color[1]), Share(color[2]),
                static_cast<float>(opacity));
}

void Canvas::Text(int x, int y, const std::string& text, const Color& color) const {
  // A margin, because OpenGL drops a text whole whose first pixel is outside of its area.
  constexpr int kMargin = 4;
  const mjrRect area = {x - kMargin, y - LineHeight() / 2 - kMargin, Width(text) + 2 * kMargin,
                        LineHeight() + 2 * kMargin};
  mjr_label(area, mjFONT_NORMAL, text.c_str(), 0, 0, 0, 0, Share(color[0]), Share(color[1]),
            Share(color[2]), &context_);
}

void Canvas::CentredText(int x, int y, const std::string& text, const Color& color) const {
  Text(x - Width(text) / 2, y, text, color);
}

int Canvas::Width(const std::string& text) const {
  int width = 0;
  for (const char character : text) {
    const auto code = static_cast<unsigned char>(character);
    width += context_.charWidth[code < 127 ? code : '?'];
  }
  return width;
}

}  // namespace metronome::render
