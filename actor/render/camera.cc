#include "actor/render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome {
namespace {

constexpr const char* kFree = "free";

/// Where a free camera stands: metres and degrees; azimuth 90 looks away from the robot's base.
struct View {
  std::array<double, 3> look_at;
  double distance, azimuth, elevation;
};

const View& ViewOf(const std::string& task) {
  static const View any = {{0, 0.65, 0.1}, 0.9, 140, -25};
  static const std::map<std::string, View> views = {
      {"assembly", {{0.02, 0.7, 0.14}, 0.75, 140, -20}},
      {"bin-picking", {{0, 0.68, 0.1}, 0.85, 115, -30}},
      {"box-close", {{0, 0.65, 0.12}, 0.85, 150, -25}},
      {"push", {{0.03, 0.72, 0.14}, 0.75, 140, -20}},
  };
  const auto found = views.find(task);
  return found == views.end() ? any : found->second;
}

/// "AZIMUTH,ELEVATION,DISTANCE[,X,Y,Z]"; std::nullopt if it is anything else.
std::optional<View> ParseView(const std::string& text, View view) {
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto number = ParseNumber<double>(word);
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

mjvCamera FreeCamera(const View& view) {
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

mjvCamera FindCamera(const mjModel& model, const std::string& task, const std::string& name) {
  if (name == kFree) return FreeCamera(ViewOf(task));
  if (const auto view = ParseView(name, ViewOf(task))) return FreeCamera(*view);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, name.c_str());
  if (camera.fixedcamid < 0) {
    throw std::invalid_argument(UnknownName("camera", name, CameraNames(model)));
  }
  return camera;
}

}  // namespace metronome
