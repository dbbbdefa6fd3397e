#include "actor/replay/recording.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "common/text/number_text.h"

namespace metronome::replay {
namespace {

using Json = nlohmann::json;
using Numbers = std::vector<double>;

struct GzClose {
  void operator()(gzFile_s* file) const { gzclose_r(file); }
};

// gzread passes plain files through.
std::string ReadAll(const std::string& path) {
  std::unique_ptr<gzFile_s, GzClose> file(gzopen(path.c_str(), "rb"));
  if (!file) throw std::invalid_argument("cannot be opened");
  std::string text;
  std::array<char, 1 << 16> block{};
  for (;;) {
    const int got = gzread(file.get(), block.data(), block.size());
    if (got < 0) throw std::invalid_argument("cannot be read, or is not what gzip wrote");
    if (got == 0) break;
    text.append(block.data(), static_cast<std::size_t>(got));
  }
  if (gzclose_r(file.release()) != Z_OK) throw std::invalid_argument("is cut short (gzip)");
  return text;
}

/// Less what editors add that save a file: a mark of UTF-8 before it, carriage returns in it.
std::string Plain(std::string text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  std::erase(text, '\r');
  return text;
}

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t from = 0;;) {
    const std::size_t comma = line.find(',', from);
    fields.push_back(line.substr(from, comma - from));
    if (comma == std::string_view::npos) return fields;
    from = comma + 1;
  }
}

/// The file's table: named columns of numbers.
class Table {
 public:
  explicit Table(std::string_view names) {
    for (const std::string_view name : Split(names)) names_.emplace_back(name);
  }

  [[nodiscard]] std::optional<std::size_t> Column(const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names_.begin());
  }

  /// Columns PREFIX0, PREFIX1, ... as far as there are; at least `least`.
  [[nodiscard]] std::vector<std::size_t> Columns(const std::string& prefix,
                                                 std::size_t least = 1) const {
    std::vector<std::size_t> columns;
    while (const auto column = Column(prefix + std::to_string(columns.size())))
      columns.push_back(*column);
    if (columns.size() < least)
      throw std::invalid_argument("has no column " + prefix + std::to_string(columns.size()));
    return columns;
  }

  /// Empty cells are NaN.
  [[nodiscard]] Numbers Row(std::string_view line, std::size_t row) const {
    const auto fields = Split(line);
    if (fields.size() != names_.size())
      throw std::invalid_argument("row " + std::to_string(row) + " has " +
                                  std::to_string(fields.size()) + " numbers, not " +
                                  std::to_string(names_.size()) + ": the file is cut short");
    Numbers numbers(fields.size());
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto number = fields[i].empty() ? std::numeric_limits<double>::quiet_NaN()
                                            : text::ParseNumber<double>(fields[i]);
      if (!number)
        throw std::invalid_argument("row " + std::to_string(row) + ", column " + names_[i] +
                                    ": \"" + std::string(fields[i]) + "\" is not a number");
      numbers[i] = *number;
    }
    return numbers;
  }

 private:
  std::vector<std::string> names_;
};

Numbers Pick(const Numbers& row, const std::vector<std::size_t>& columns) {
  Numbers picked;
  for (const std::size_t column : columns) picked.push_back(row[column]);
  return picked;
}

bool AnyEmpty(const Numbers& numbers) {
  return std::ranges::any_of(numbers, [](double number) { return std::isnan(number); });
}

bool AllEmpty(const std::vector<Numbers>& lists) {
  return std::ranges::all_of(lists, [](const Numbers& numbers) {
    return std::ranges::all_of(numbers, [](double number) { return std::isnan(number); });
  });
}

template <std::size_t N>
std::array<double, N> Array(const Json& json, const char* what) {
  const auto numbers = json.get<Numbers>();
  if (numbers.size() != N)
    throw std::invalid_argument(std::string(what) + " has " + std::to_string(numbers.size()) +
                                " numbers, not " + std::to_string(N));
  std::array<double, N> array{};
  std::copy(numbers.begin(), numbers.end(), array.begin());
  return array;
}

Eigen::Vector3d Vector(const Json& json, const char* what) {
  return Eigen::Map<const Eigen::Vector3d>(Array<3>(json, what).data());
}

std::map<std::string, Eigen::Vector3d> Positions(const Json& json, const char* what) {
  std::map<std::string, Eigen::Vector3d> positions;
  for (const auto& [name, position] : json.items()) positions[name] = Vector(position, what);
  return positions;
}

// The official attributes are numbers, vectors or null. Those that the header says are views of the
// engine's arrays (internals_live) are here as they were after the reset; no task takes them.
std::map<std::string, Numbers> Internals(const Json& json) {
  std::map<std::string, Numbers> internals;
  for (const auto& [name, value] : json.items())
    if (value.is_array())
      internals[name] = value.get<Numbers>();
    else if (value.is_number())
      internals[name] = {value.get<double>()};
  return internals;
}

/// The columns of what step() gave; none of them matters to a replay, so a file may lack them.
class ReturnedColumns {
 public:
  explicit ReturnedColumns(const Table& table) : observation_(table.Columns("obs", 0)) {
    for (const char* name : {"reward", "success", "near_object", "grasp_success", "grasp_reward",
                             "in_place_reward", "obj_to_target", "truncated"})
      if (const auto column = table.Column(name)) scalars_.push_back(*column);
  }

  [[nodiscard]] std::optional<metaworld::StepResult> Read(const Numbers& row) const {
    if (observation_.size() != metaworld::kObservationSize || scalars_.size() != 8)
      return std::nullopt;
    metaworld::StepResult result;
    const Numbers observation = Pick(row, observation_), scalars = Pick(row, scalars_);
    if (AnyEmpty(observation) || AnyEmpty(scalars)) return std::nullopt;
    std::copy(observation.begin(), observation.end(), result.observation.begin());
    result.reward = scalars[0];
    result.info = {scalars[1] != 0, scalars[2], scalars[3], scalars[4], scalars[5], scalars[6]};
    result.truncated = scalars[7] != 0;
    return result;
  }

 private:
  std::vector<std::size_t> observation_, scalars_;
};

/// Six numbers, or three of tasks without a goal in their placement.
metaworld::RandVec Placement(const Json& json) {
  metaworld::RandVec placement{};
  if (json.size() == placement.size()) return Array<6>(json, "rand_vec");
  std::ranges::copy(Array<3>(json, "rand_vec"), placement.begin());
  return placement;
}

/// @return the number of steps that the header promises.
std::size_t ReadHeader(std::string_view line, Recording& recording) {
  if (!line.starts_with("# "))
    throw std::invalid_argument("does not start with a \"# \" line of JSON");
  const Json header = Json::parse(line.substr(2));
  recording.task = header.at("task").get<std::string>();
  recording.placement = Placement(header.at("rand_vec"));
  recording.start = {
      .observation = Array<metaworld::kObservationSize>(header.at("init_obs"), "init_obs"),
      .goal = Vector(header.at("goal"), "goal"),
      .internals = Internals(header.at("internals_after_reset")),
      .bodies = Positions(header.at("model_body_pos_changed"), "model_body_pos_changed"),
      .sites = Positions(header.at("model_site_pos_changed"), "model_site_pos_changed")};
  return header.at("steps").get<std::size_t>();
}

void ReadSteps(std::istream& lines, std::size_t promised, Recording& recording) {
  std::string line;
  if (!std::getline(lines, line)) throw std::invalid_argument("has no line of column names");
  const Table table(line);
  const auto qpos = table.Columns("qpos"), qvel = table.Columns("qvel"),
             mocap_pos = table.Columns("mocap_pos"), mocap_quat = table.Columns("mocap_quat"),
             ctrl = table.Columns("ctrl"), warm = table.Columns("warm"),
             action = table.Columns("action", metaworld::kActionSize);
  const ReturnedColumns returned(table);
  while (std::getline(lines, line)) {
    const Numbers row = table.Row(line, recording.steps.size() + 1);
    RecordedStep step;
    if (AnyEmpty(Pick(row, action)))
      throw std::invalid_argument("row " + std::to_string(recording.steps.size() + 1) +
                                  " has no action");
    for (std::size_t i = 0; i < step.action.size(); ++i)
      step.action[i] = static_cast<float>(row[action[i]]);
    std::vector<Numbers> state;
    bool whole = true;
    for (const auto* columns : {&qpos, &qvel, &mocap_pos, &mocap_quat, &ctrl, &warm}) {
      state.push_back(Pick(row, *columns));
      whole = whole && !AnyEmpty(state.back());
    }
    if (whole)
      step.state = {state[0], state[1], state[2], state[3], state[4], state[5]};
    else if (!AllEmpty(state))
      throw std::invalid_argument("row " + std::to_string(recording.steps.size() + 1) +
                                  " has a part of a state: the file is cut short");
    step.returned = returned.Read(row);
    recording.steps.push_back(std::move(step));
  }
  const std::size_t steps = recording.steps.size();
  if (steps != promised)
    throw std::invalid_argument("has " + std::to_string(steps) + " steps, its header promises " +
                                std::to_string(promised) + ": the file is cut short");
  if (steps == 0 || steps > metaworld::kMaxSteps)
    throw std::invalid_argument("has " + std::to_string(steps) + " steps, not 1 to " +
                                std::to_string(metaworld::kMaxSteps));
}

}  // namespace

Recording ReadRecording(const std::string& path) {
  try {
    Recording recording;
    std::istringstream lines(Plain(ReadAll(path)));
    std::string header;
    std::getline(lines, header);
    const std::size_t promised = ReadHeader(header, recording);
    ReadSteps(lines, promised, recording);
    return recording;
  } catch (const Json::exception& error) {
    throw std::invalid_argument("recording " + path + ": header line: " + error.what());
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("recording " + path + ": " + error.what());
  }
}

}  // namespace metronome::replay
