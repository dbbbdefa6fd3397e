#include "learner/collect/trust/excluded_hosts.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/process/files.h"

namespace metronome::collect::trust {

std::string ExcludedHostsPathOf(const std::string& run_folder) {
  return run_folder + "/excluded.json";
}

ExcludedHosts LoadExcludedHosts(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  const std::string content = process::ReadFile(path);
  try {
    return nlohmann::json::parse(content).get<ExcludedHosts>();
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(path + " does not say which hosts are excluded (" + error.what() +
                                R"(): write it as {"host": "reason"}, or remove it to let all in)");
  }
}

void SaveExcludedHosts(const ExcludedHosts& hosts, const std::string& path) {
  // A host's name is its own word, so it may not be text.
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  process::WriteFileAtomically(path, nlohmann::json(hosts).dump(2, ' ', false, kReplace) + "\n");
}

}  // namespace metronome::collect::trust
