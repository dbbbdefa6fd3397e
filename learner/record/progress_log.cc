#include "learner/record/progress_log.h"

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "common/process/files.h"
#include "common/text/number_text.h"

namespace metronome::record {
namespace {

std::size_t WholeLines(std::string_view content) {
  const std::size_t last = content.rfind('\n');
  return last == std::string_view::npos ? 0 : last + 1;
}

std::string ValueText(const algorithm::Metric& metric) {
  if (const auto* whole = std::get_if<std::uint64_t>(&metric.value)) return std::to_string(*whole);
  return text::FormatNumber(std::get<double>(metric.value));
}

std::string HeaderOf(const algorithm::UpdateReport& blank) {
  std::string header;
  for (const algorithm::Metric& metric : MetricsOf(blank, {})) {
    if (!header.empty()) header += ',';
    header += metric.column;
  }
  return header + "\n";
}

/// Two columns had other names until version 0.1; a file that has them goes on with them.
std::string WithNewNames(std::string header) {
  constexpr std::pair<std::string_view, std::string_view> kRenamed[] = {
      {"wall_slots", "wall_envs"}, {"wall_orders_repeated", "wall_episodes_reassigned"}};
  for (const auto& [before, now] : kRenamed) {
    const std::size_t at = header.find(before);
    if (at != std::string::npos) header.replace(at, before.size(), now);
  }
  return header;
}

}  // namespace

void ProgressLog::RequireHeader(const std::string& path, const algorithm::UpdateReport& blank) {
  if (!std::filesystem::exists(path)) return;
  const std::string content = process::ReadFile(path);
  const std::size_t size = content.find('\n') + 1;
  if (size == 0 || WithNewNames(content.substr(0, size)) == HeaderOf(blank)) return;
  throw std::invalid_argument(
      path +
      " has other columns than this build writes: go on with the build that wrote it, or move the "
      "file away, and a new one begins with the next update");
}

ProgressLog::ProgressLog(const std::string& path, const algorithm::UpdateReport& blank,
                         std::uint64_t keep_bytes)
    : file_(path, keep_bytes, WholeLines) {
  if (file_.size() == 0) file_.Append(HeaderOf(blank));
}

void ProgressLog::Append(const std::vector<algorithm::Metric>& metrics) {
  std::string row;
  for (const algorithm::Metric& metric : metrics) {
    if (!row.empty()) row += ',';
    row += ValueText(metric);
  }
  row += '\n';
  file_.Append(row);
}

}  // namespace metronome::record
