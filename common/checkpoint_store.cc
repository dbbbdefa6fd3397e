#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "common/checkpoint.h"
#include "common/files.h"
#include "common/number_text.h"

namespace metronome {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".ckpt";
constexpr std::string_view kLatest = "latest";

std::string FileName(std::uint64_t version) {
  std::string digits = std::to_string(version);
  if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
  return digits + std::string(kSuffix);
}

/// Checkpoint files of the folder by version; none where it cannot be read.
std::map<std::uint64_t, fs::path> FilesIn(const fs::path& folder) {
  std::map<std::uint64_t, fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(kSuffix)) continue;
    const auto version =
        ParseNumber<std::uint64_t>(std::string_view(name).substr(0, name.size() - kSuffix.size()));
    if (version) files[*version] = entry.path();
  }
  return files;
}

}  // namespace

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
  WriteFileAtomically(path, EncodeCheckpoint(checkpoint));
  ReplaceSymlink((fs::path(folder_) / kLatest).string(), name);
  Prune();
  return path;
}

std::optional<std::string> CheckpointStore::Latest() const {
  const fs::path link = fs::path(folder_) / kLatest;
  std::error_code unreadable;  // asked when a disk fails, too: what is not there is not named
  const fs::path target = fs::read_symlink(link, unreadable);
  if (!unreadable) return (fs::path(folder_) / target).string();
  const auto files = FilesIn(folder_);
  if (files.empty()) return std::nullopt;
  return files.rbegin()->second.string();
}

void CheckpointStore::Prune() const {
  const fs::path latest = fs::read_symlink(fs::path(folder_) / kLatest);
  auto files = FilesIn(folder_);
  if (milestone_every_ > 0) {
    std::erase_if(files, [this](const auto& file) { return file.first % milestone_every_ == 0; });
  }
  auto left = static_cast<int>(files.size());
  for (const auto& [version, path] : files) {
    if (left-- <= keep_) return;
    if (path.filename() == latest.filename()) continue;
    std::error_code ignored;  // an old file too many does no harm
    fs::remove(path, ignored);
  }
}

}  // namespace metronome
