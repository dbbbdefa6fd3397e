#include "actor/render/camera.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome::render {
namespace {

constexpr const char* kFree = "free";

/// "AZIMUTH,ELEVATION,DISTANCE[,X,Y,Z]"; std::nullopt if it is anything else.
std::optional<environment::CameraView> ParseView(const std::string& text,
                                                 environment::CameraView view) {
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto number = text::ParseNumber<double>(word);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  if ((numbers.size() != 3 && numbers.size() != 6) || numbers[2] <= 0) return std::nullopt;
  view.azimuth = numbers[0];
  view.elevation = numbers[1];
  view.distance = numbers[2];
  if (numbers.size() == 6) std::copy_n(numbers.begin() + 3, 3, view.look_at.begin());
  return view;
}

mjvCamera FreeCamera(const environment::CameraView& view) {
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FREE;
  std::copy(view.look_at.begin(), view.look_at.end(), camera.lookat);
  camera.distance = view.distance;
  camera.azimuth = view.azimuth;
  camera.elevation = view.elevation;
  return camera;
}

}  // namespace

std::vector<std::string> CameraNames(const mjModel& model) {
  std::vector<std::string> names = {kFree};
  for (int i = 0; i < model.ncam; ++i) {
    const char* name = mj_id2name(&model, mjOBJ_CAMERA, i);
    if (name != nullptr) names.emplace_back(name);
  }
  return names;
}

mjvCamera FindCamera(const mjModel& model, const environment::CameraView& free,
                     const std::string& name) {
  if (name == kFree) return FreeCamera(free);
  if (const auto view = ParseView(name, free)) return FreeCamera(*view);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, name.c_str());
  if (camera.fixedcamid < 0) {
    throw std::invalid_argument(text::UnknownName("camera", name, CameraNames(model)));
  }
  return camera;
}

}  // namespace metronome::render
