#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/process/files.h"
#include "common/text/number_text.h"

namespace metronome::checkpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".ckpt";
constexpr std::string_view kLatest = "latest";
constexpr std::string_view kAside = ".damaged";

using Files = std::map<std::uint64_t, fs::path, std::greater<>>;  // by version, newest first

std::string FileName(std::uint64_t version) {
  std::string digits = std::to_string(version);
  if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
  return digits + std::string(kSuffix);
}

std::optional<std::uint64_t> VersionOf(const fs::path& path) {
  const std::string name = path.filename().string();
  if (!name.ends_with(kSuffix)) return std::nullopt;
  return text::ParseNumber<std::uint64_t>(
      std::string_view(name).substr(0, name.size() - kSuffix.size()));
}

/// The names that lie in a folder. @param error  why it cannot be read; it then counts as empty.
std::vector<fs::path> EntriesOf(const fs::path& folder, std::error_code& error) {
  std::vector<fs::path> paths;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    paths.push_back(entry->path());
  }
  return paths;
}

Files FilesAmong(const std::vector<fs::path>& entries) {
  Files files;
  for (const fs::path& path : entries) {
    if (const auto version = VersionOf(path)) files[*version] = path;
  }
  return files;
}

Files FilesIn(const fs::path& folder) {
  std::error_code ignored;
  return FilesAmong(EntriesOf(folder, ignored));
}

/// "; there are 000124.ckpt, ... in FOLDER": what else may be taken in place of `path`.
std::string OthersBeside(const fs::path& path) {
  std::error_code error;
  std::string text;
  if (fs::is_symlink(fs::symlink_status(path, error)) && !fs::exists(path, error)) {
    text = " (it leads to " + fs::read_symlink(path, error).string() + ")";
  }
  const fs::path named = fs::is_symlink(path, error) ? fs::read_symlink(path, error) : path;
  fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (fs::is_directory(path, error)) {  // a run's folder, or its folder of checkpoints
    folder = fs::is_directory(path / "checkpoints", error) ? path / "checkpoints" : path;
  }
  std::string names;
  int left = 5;
  for (const auto& [version, file] : FilesIn(folder)) {
    if (file.filename() == named.filename() || left-- == 0) continue;
    names += (names.empty() ? "; there are " : ", ") + file.filename().string();
  }
  return text + names + (names.empty() ? "" : " in " + folder.string());
}

Checkpoint ReadCheckpoint(const fs::path& path, const config::SpecSource& source) {
  std::string bytes;
  try {
    bytes = process::ReadFile(path.string());
  } catch (const std::system_error& error) {
    throw CheckpointUnreadable("cannot read checkpoint " + path.string() + ": " +
                               error.code().message());
  }
  return DecodeCheckpoint(bytes, path.string(), source);
}

/// The files that a run may go on from, best first. @param latest  FOLDER/latest; not among
/// `files`.
std::vector<fs::path> Candidates(const fs::path& latest, const Files& files) {
  std::error_code error;
  const auto there = fs::symlink_status(latest, error);
  std::vector<fs::path> candidates;
  std::optional<std::uint64_t> named;
  if (fs::is_symlink(there)) {
    candidates.push_back(latest.parent_path() / fs::read_symlink(latest, error));
    named = VersionOf(candidates.front());
  } else if (fs::exists(there)) {
    candidates.push_back(latest);  // a copy that did not keep the link
  }
  // Of its own version there is another file if `latest` leads elsewhere.
  const auto older = named ? files.lower_bound(*named) : files.begin();
  for (auto file = older; file != files.end(); ++file) {
    const bool is_latest = named && fs::equivalent(file->second, candidates.front(), error);
    if (!is_latest) candidates.push_back(file->second);
  }
  for (auto file = files.begin(); file != older; ++file) candidates.push_back(file->second);
  return candidates;
}

/// Why it cannot be gone on from and never can be, or nothing and the checkpoint is in `found`.
/// @throws CheckpointError if it may be whole.
std::optional<std::string> Take(const fs::path& path, const config::SpecSource& source,
                                FoundCheckpoint& found) {
  std::error_code error;
  const auto there = fs::status(path, error);
  if (there.type() == fs::file_type::not_found ||
      error == std::errc::too_many_symbolic_link_levels) {
    return path.string() + ": missing";
  }
  if (fs::exists(there) && !fs::is_regular_file(there)) return path.string() + ": not a file";
  try {
    found.checkpoint = ReadCheckpoint(path, source);
  } catch (const CheckpointDamaged& damaged) {
    return damaged.what();
  }
  found.path = path.string();
  return std::nullopt;
}

/// A path as a shell takes it.
std::string Quoted(const std::string& path) {
  std::string quoted = "'";
  for (const char c : path) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

/// The error again, with the command that goes back to another checkpoint, if there is one.
[[noreturn]] void RefuseWithWayBack(const CheckpointError& refused, const fs::path& path,
                                    const fs::path& latest, const Files& files) {
  std::string text = refused.what();
  const auto other = std::find_if(files.begin(), files.end(), [&](const auto& file) {
    return file.second.filename() != path.filename();
  });
  if (other != files.end()) {
    text += "; or go back to another one, say: ln -sfn " + other->second.filename().string() + " " +
            Quoted(latest.string());
  }
  if (dynamic_cast<const CheckpointUnreadable*>(&refused)) throw CheckpointUnreadable(text);
  throw CheckpointError(text);
}

/// Names everything in the folder that was a checkpoint; returns if nothing was.
void RequireNoTrace(const std::string& folder, const std::vector<fs::path>& entries,
                    const std::vector<FoundCheckpoint::PassedOver>& passed_over) {
  std::string traces;
  for (const auto& passed : passed_over) traces += "\n  " + passed.why;
  for (const fs::path& path : entries) {
    if (!path.filename().string().ends_with(kAside)) continue;
    traces.append("\n  ").append(path.string()).append(": put aside by an earlier start");
  }
  if (traces.empty()) return;
  throw CheckpointDamaged("no checkpoint in " + folder + " is whole:" + traces +
                          "\n  put a copy of one of them there, or begin anew under another --run");
}

}  // namespace

Checkpoint LoadCheckpoint(const std::string& path, const config::SpecSource& source) {
  try {
    return ReadCheckpoint(path, source);
  } catch (const CheckpointDamaged& error) {
    throw CheckpointDamaged(error.what() + OthersBeside(path));
  } catch (const CheckpointUnreadable& error) {
    throw CheckpointUnreadable(error.what() + OthersBeside(path));
  }
}

std::optional<FoundCheckpoint> FindNewestCheckpoint(const std::string& folder,
                                                    const config::SpecSource& source) {
  std::error_code error;
  const std::vector<fs::path> entries = EntriesOf(folder, error);
  if (error == std::errc::no_such_file_or_directory) return std::nullopt;
  if (error) throw CheckpointUnreadable("cannot read " + folder + ": " + error.message());
  const fs::path latest = fs::path(folder) / kLatest;
  const Files files = FilesAmong(entries);
  FoundCheckpoint found;
  for (const fs::path& path : Candidates(latest, files)) {
    try {
      const auto why = Take(path, source, found);
      if (!why) return found;
      found.passed_over.push_back({path.string(), *why});
    } catch (const CheckpointError& refused) {
      RefuseWithWayBack(refused, path, latest, files);
    }
  }
  RequireNoTrace(folder, entries, found.passed_over);
  return std::nullopt;
}

CheckpointStore::CheckpointStore(std::string folder, int keep, int milestone_every)
    : folder_(std::move(folder)),
      keep_(keep),
      milestone_every_(static_cast<std::uint64_t>(milestone_every)) {
  fs::create_directories(folder_);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.path().filename().string().find(".tmp.") == std::string::npos) continue;
    std::error_code ignored;  // left in place, it does no harm
    fs::remove(entry.path(), ignored);
  }
}

std::string CheckpointStore::Save(const Checkpoint& checkpoint) {
  const std::string name = FileName(checkpoint.state.version);
  std::string path = (fs::path(folder_) / name).string();
  process::WriteFileAtomically(path, EncodeCheckpoint(checkpoint));
  process::ReplaceSymlink((fs::path(folder_) / kLatest).string(), name);
  Prune(checkpoint.state.version);
  return path;
}

void CheckpointStore::GoOnFrom(const FoundCheckpoint& found) {
  for (const auto& passed : found.passed_over) PutAside(passed.path);
  const fs::path path(found.path);
  if (!found.passed_over.empty() && path.filename() != kLatest) {
    process::ReplaceSymlink((fs::path(folder_) / kLatest).string(), path.filename().string());
  }
}

// Under a name that is free: nothing is lost. What a link leads to elsewhere is not ours to move.
void CheckpointStore::PutAside(const std::string& path) const {
  std::error_code error;
  if (!fs::equivalent(fs::path(path).parent_path(), folder_, error)) return;
  if (!fs::exists(fs::symlink_status(path))) return;
  std::string to = path + std::string(kAside);
  for (int count = 2; fs::exists(fs::symlink_status(to)); ++count) {
    to = path + "." + std::to_string(count) + std::string(kAside);
  }
  fs::rename(path, to, error);
  if (error) throw std::system_error(error, "cannot put " + path + " aside as " + to);
}

std::optional<std::string> CheckpointStore::Latest() const {
  const fs::path link = fs::path(folder_) / kLatest;
  std::error_code unreadable;  // asked when a disk fails, too: what is not there is not named
  const fs::path target = fs::read_symlink(link, unreadable);
  if (!unreadable) return (fs::path(folder_) / target).string();
  const auto files = FilesIn(folder_);
  if (files.empty()) return std::nullopt;
  return files.begin()->second.string();
}

void CheckpointStore::Prune(std::uint64_t newest) const {
  int left = keep_;
  for (const auto& [version, path] : FilesIn(folder_)) {
    if (version > newest) continue;  // the run was set back; it comes by again
    if (milestone_every_ > 0 && version % milestone_every_ == 0) continue;
    if (left-- > 0) continue;
    std::error_code ignored;  // an old file too many does no harm
    fs::remove(path, ignored);
  }
}

}  // namespace metronome::checkpoint
