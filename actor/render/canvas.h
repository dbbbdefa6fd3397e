#pragma once

#include <mujoco/mujoco.h>

#include <string>

#include "actor/render/head_colors.h"

namespace metronome::render {

/// Flat colours and text on top of what a SceneRenderer has drawn. Pixels, from the lower left.
class Canvas {
 public:
  explicit Canvas(const mjrContext& context) : context_(context) {}

  void Fill(const mjrRect& area, const Color& color, double opacity = 1) const;
  /// Text whose left end is at x; its line is centred at y. Nothing is drawn left or below of 0.
  void Text(int x, int y, const std::string& text, const Color& color) const;
  void CentredText(int x, int y, const std::string& text, const Color& color) const;

  [[nodiscard]] int Width(const std::string& text) const;
  [[nodiscard]] int LineHeight() const { return context_.charHeight; }

 private:
  const mjrContext& context_;
};

}  // namespace metronome::render
