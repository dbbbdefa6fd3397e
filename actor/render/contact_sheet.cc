#include "actor/render/contact_sheet.h"

#include <algorithm>
#include <ostream>
#include <stdexcept>

#include "actor/environment/mujoco_view.h"
#include "actor/render/camera.h"
#include "actor/render/canvas.h"
#include "actor/render/episode_path.h"
#include "actor/render/scene_renderer.h"

namespace metronome::render {
namespace {

constexpr Color kInk = {20, 20, 20};
constexpr Color kPaper = {245, 245, 245};

void Caption(const SceneRenderer& renderer, const std::string& text, ImageSize size) {
  const Canvas canvas(renderer.context());
  const int height = canvas.LineHeight() * 3 / 2;
  canvas.Fill({0, size.height - height, size.width, height}, kPaper, 0.8);
  canvas.CentredText(size.width / 2, size.height - height / 2, text, kInk);
}

Image Tile(const environment::EnvironmentRegistry& registry, const std::string& name,
           ImageSize size) {
  EnvironmentConfig config;
  *config.mutable_spec() = registry.Describe(name);
  config.set_task(config.spec().short_name());
  const auto environment = registry.Make(config);
  const environment::MujocoView* scene = environment->mujoco();
  if (scene == nullptr)
    throw std::invalid_argument("environment " + name + " cannot be drawn: it is not in MuJoCo");
  std::vector<float> observation(static_cast<std::size_t>(config.spec().observation_size()));
  environment::EpisodeStart start({numbers::RandomPurpose::kEvaluate, 0, 0});
  environment->Reset(start, observation);
  SceneRenderer renderer(scene->model(), FindCamera(scene->model(), scene->view(), "free"), size, 0,
                         1);
  renderer.Draw(PoseOf(scene->model(), scene->data()), {}, {0, 0, size.width, size.height});
  Caption(renderer, config.task(), size);
  return renderer.Read();
}

void Paste(const Image& tile, int column, int row, Image& sheet) {
  const auto tile_row = static_cast<std::size_t>(tile.size.width) * 3;
  const auto sheet_row = static_cast<std::size_t>(sheet.size.width) * 3;
  const std::size_t left = static_cast<std::size_t>(column) * tile_row;
  for (std::size_t y = 0; y < static_cast<std::size_t>(tile.size.height); ++y) {
    const std::size_t to = static_cast<std::size_t>(row * tile.size.height) + y;
    std::copy_n(tile.rgb.begin() + static_cast<std::ptrdiff_t>(y * tile_row), tile_row,
                sheet.rgb.begin() + static_cast<std::ptrdiff_t>(to * sheet_row + left));
  }
}

}  // namespace

Image ContactSheet(const environment::EnvironmentRegistry& registry,
                   const std::vector<std::string>& names, int columns, ImageSize tile) {
  const int rows = (static_cast<int>(names.size()) + columns - 1) / columns;
  Image sheet{{columns * tile.width, rows * tile.height}, {}};
  sheet.rgb.resize(
      static_cast<std::size_t>(sheet.size.width) * static_cast<std::size_t>(sheet.size.height) * 3,
      255);
  for (int i = 0; i < static_cast<int>(names.size()); ++i)
    Paste(Tile(registry, names[static_cast<std::size_t>(i)], tile), i % columns, i / columns,
          sheet);
  return sheet;
}

int RunContactSheet(const std::string& path, const environment::EnvironmentRegistry& registry,
                    std::ostream& out, std::ostream& err) {
  constexpr int kColumns = 5;
  try {
    std::vector<std::string> names;
    for (const environment::EnvironmentEntry& entry : registry.entries())
      names.push_back(entry.spec.short_name());
    WritePng(path, ContactSheet(registry, names, kColumns, {200, 160}));
    out << "wrote " << path << '\n' << std::flush;
    return 0;
  } catch (const std::exception& error) {
    err << "error: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace metronome::render
