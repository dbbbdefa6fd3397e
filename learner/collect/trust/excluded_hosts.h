#pragma once

#include <map>
#include <string>

/// Hosts that an audit sent away from a run, kept in FOLDER/excluded.json, so that a learner that
/// starts again does not let them in. The file is JSON, {"host": "reason", ...}: to let a host in
/// again, take its entry out and start the learner again.
namespace metronome::collect::trust {

using ExcludedHosts = std::map<std::string, std::string>;  // host -> reason

std::string ExcludedHostsPathOf(const std::string& run_folder);

/// Empty if there is no such file. @throws std::invalid_argument naming the path and the remedy if
/// it is not of that form, std::system_error if it cannot be read.
ExcludedHosts LoadExcludedHosts(const std::string& path);

/// Atomically. @throws std::system_error.
void SaveExcludedHosts(const ExcludedHosts& hosts, const std::string& path);

}  // namespace metronome::collect::trust
