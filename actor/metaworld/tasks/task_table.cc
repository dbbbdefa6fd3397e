#include "actor/metaworld/tasks/task_table.h"

#include <stdexcept>

#include "common/text/near_miss.h"

namespace metronome::metaworld::tasks {

// Defined in tasks/NAME.cc.
std::unique_ptr<SawyerEnvironment> MakeAssembly(const TaskSpec&, const EnvironmentOptions&);
std::unique_ptr<SawyerEnvironment> MakeBinPicking(const TaskSpec&, const EnvironmentOptions&);
std::unique_ptr<SawyerEnvironment> MakeBoxClose(const TaskSpec&, const EnvironmentOptions&);
std::unique_ptr<SawyerEnvironment> MakePush(const TaskSpec&, const EnvironmentOptions&);

const std::vector<TaskSpec>& AllTasks() {
  // name, scene, box low (object, goal), box high, least planar distance, view, factory
  static const std::vector<TaskSpec> tasks = {
      {"assembly",
       "sawyer_xyz/sawyer_assembly_peg.xml",
       {0, 0.6, 0.02, -0.1, 0.75, 0.1},
       {0, 0.6, 0.02, 0.1, 0.85, 0.1},
       0.1,
       {{0.02, 0.7, 0.14}, 0.75, 140, -20},
       MakeAssembly},
      {"bin-picking",
       "sawyer_xyz/sawyer_bin_picking.xml",
       {-0.21, 0.65, 0.02, 0.1199, 0.699, -0.001},
       {-0.03, 0.75, 0.02, 0.1201, 0.701, 0.001},
       0,
       {{0, 0.68, 0.1}, 0.85, 115, -30},
       MakeBinPicking},
      {"box-close",
       "sawyer_xyz/sawyer_box.xml",
       {-0.05, 0.5, 0.02, -0.1, 0.7, 0.133},
       {0.05, 0.55, 0.02, 0.1, 0.8, 0.133},
       0.25,
       {{0, 0.65, 0.12}, 0.85, 150, -25},
       MakeBoxClose},
      {"push",
       "sawyer_xyz/sawyer_push_v3.xml",
       {-0.1, 0.6, 0.02, -0.1, 0.8, 0.01},
       {0.1, 0.7, 0.02, 0.1, 0.9, 0.02},
       0.15,
       {{0.03, 0.72, 0.14}, 0.75, 140, -20},
       MakePush},
  };
  return tasks;
}

const TaskSpec& FindTask(const std::string& spelling) {
  std::string name = spelling;
  if (name.ends_with("-v2") || name.ends_with("-v3")) name.resize(name.size() - 3);
  std::vector<std::string> names;
  for (const TaskSpec& task : AllTasks()) {
    if (task.name == name) return task;
    names.push_back(task.name);
  }
  throw std::invalid_argument(
      text::UnknownName("task", spelling, names, text::NearMiss(name, names)));
}

std::unique_ptr<SawyerEnvironment> MakeSawyerEnvironment(const std::string& task,
                                                         const EnvironmentOptions& options) {
  const TaskSpec& spec = FindTask(task);
  return spec.make(spec, options);
}

}  // namespace metronome::metaworld::tasks
