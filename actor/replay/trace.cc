#include "actor/replay/trace.h"

#include <iostream>
#include <stdexcept>

#include "actor/metaworld/tasks/task_table.h"
#include "common/text/number_text.h"

namespace metronome::replay {
namespace {

TraceMode ParseMode(const std::string& mode) {
  if (mode == "forced") return TraceMode::kForced;
  if (mode == "free") return TraceMode::kFree;
  throw std::invalid_argument("unknown mode \"" + mode + "\". Known: forced, free");
}

std::string CsvRow(std::size_t step, const metaworld::Observation& observation) {
  std::string row = std::to_string(step);
  for (const double number : observation) row += ',' + text::FormatNumber(number);
  return row;
}

std::string Csv(const Trace& trace) {
  std::string text = "step";
  for (int i = 0; i < metaworld::kObservationSize; ++i) text += ",obs" + std::to_string(i);
  text += ",reward,success,near_object,grasp_success,grasp_reward,in_place_reward,obj_to_target\n";
  text += CsvRow(0, trace.reset) + ",,,,,,,\n";
  for (std::size_t t = 0; t < trace.steps.size(); ++t) {
    if (!trace.steps[t]) continue;
    const metaworld::StepResult& step = *trace.steps[t];
    const metaworld::StepInfo& info = step.info;
    text += CsvRow(t + 1, step.observation);
    for (const double number :
         {step.reward, info.success ? 1.0 : 0.0, info.near_object, info.grasp_success,
          info.grasp_reward, info.in_place_reward, info.obj_to_target})
      text += ',' + text::FormatNumber(number);
    text += '\n';
  }
  return text;
}

}  // namespace

Trace PlayRecording(const Recording& recording, TraceMode mode, const std::string& assets) {
  const auto environment = metaworld::tasks::MakeSawyerEnvironment(
      recording.task, {.goal_visible = true, .assets = assets});
  Trace trace;
  trace.reset = environment->Reset(recording.placement);
  if (mode == TraceMode::kForced) environment->Replay(recording.start);
  for (const RecordedStep& step : recording.steps) {
    auto& traced = trace.steps.emplace_back();
    if (mode == TraceMode::kFree)
      traced = environment->Step(step.action);
    else if (step.state)
      traced =
          environment->ReplayStep(*step.state, step.action, static_cast<int>(trace.steps.size()));
  }
  return trace;
}

int RunTrace(const TraceOptions& options, std::ostream& out) {
  try {
    const TraceMode mode = ParseMode(options.mode);
    const std::string task = metaworld::tasks::FindTask(options.task).name;
    const Recording recording = ReadRecording(options.recording);
    if (metaworld::tasks::FindTask(recording.task).name != task)
      throw std::invalid_argument("recording " + options.recording + " is of task " +
                                  recording.task + ", not " + task);
    out << Csv(PlayRecording(recording, mode, options.assets)) << std::flush;
    if (!out) throw std::runtime_error("cannot write the output");
    return 0;
  } catch (const std::invalid_argument& error) {
    std::cerr << "trace: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "trace: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace metronome::replay
