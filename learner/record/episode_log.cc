#include "learner/record/episode_log.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "common/process/files.h"
#include "common/process/sha256.h"
#include "learner/record/tensorboard.h"

namespace metronome::record {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSegmentBytes = std::uint64_t{32} << 20;  // a new one begins beyond
constexpr std::size_t kHead = 8;                                  // of a record
constexpr const char* kSuffix = ".episodes";

template <typename Number>
void Put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

template <typename Number>
void PutAll(std::string& bytes, const std::vector<Number>& numbers) {
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
}

/// Takes numbers off the front of a payload.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename Number>
  Number Take() {
    Number number{};
    Copy(&number, sizeof(number));
    return number;
  }
  template <typename Number>
  void TakeAll(std::vector<Number>& numbers, std::size_t count) {
    if (count > bytes_.size() / sizeof(Number)) {
      whole_ = false;
      return;
    }
    numbers.resize(count);
    Copy(numbers.data(), count * sizeof(Number));
  }
  [[nodiscard]] bool IsWhole() const { return whole_ && bytes_.empty(); }

 private:
  void Copy(void* to, std::size_t size) {
    if (size > bytes_.size()) {
      whole_ = false;
      return;
    }
    std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
  bool whole_ = true;
};

std::string PayloadOf(const Episode& episode) {
  const std::size_t steps = episode.reward.size();
  std::string payload;
  Put(payload, episode.number);
  Put(payload, episode.weights_version);
  Put(payload, std::uint32_t(steps));
  Put(payload, std::uint32_t(episode.observation.size() / (steps + 1)));
  Put(payload, std::uint32_t(episode.action.size() / steps));
  PutAll(payload, episode.observation);
  PutAll(payload, episode.action);
  PutAll(payload, episode.log_prob);
  PutAll(payload, episode.reward);
  PutAll(payload, episode.head);
  PutAll(payload, episode.flags);
  return payload;
}

std::optional<Episode> EpisodeOf(std::string_view payload) {
  Reader reader(payload);
  Episode episode;
  episode.number = reader.Take<std::uint64_t>();
  episode.weights_version = reader.Take<std::uint64_t>();
  const std::size_t steps = reader.Take<std::uint32_t>();
  const std::size_t observations = reader.Take<std::uint32_t>();
  const std::size_t actions = reader.Take<std::uint32_t>();
  reader.TakeAll(episode.observation, (steps + 1) * observations);
  reader.TakeAll(episode.action, steps * actions);
  reader.TakeAll(episode.log_prob, steps);
  reader.TakeAll(episode.reward, steps);
  reader.TakeAll(episode.head, steps);
  reader.TakeAll(episode.flags, steps);
  if (!reader.IsWhole() || steps == 0) return std::nullopt;
  return episode;
}

/// One record at the front of `content`, whose checksum is right; std::nullopt for anything else.
struct Record {
  std::string_view payload;
  std::uint32_t checksum = 0;
};

std::optional<Record> RecordAt(std::string_view content) {
  if (content.size() < kHead) return std::nullopt;
  Reader head(content.substr(0, kHead));
  const auto size = head.Take<std::uint32_t>();
  Record record;
  record.checksum = head.Take<std::uint32_t>();
  if (size > content.size() - kHead) return std::nullopt;
  record.payload = content.substr(kHead, size);
  if (Crc32c(record.payload) != record.checksum) return std::nullopt;
  return record;
}

/// Bytes of the records before episode `next`, of those that are whole.
std::size_t BytesBefore(std::string_view content, std::uint64_t next) {
  std::size_t at = 0;
  while (const auto record = RecordAt(content.substr(at))) {
    Reader payload(record->payload);
    if (payload.Take<std::uint64_t>() >= next) break;
    at += kHead + record->payload.size();
  }
  return at;
}

std::string SegmentPath(const std::string& folder, std::uint64_t first) {
  char name[32];
  std::snprintf(name, sizeof(name), "%012llu", static_cast<unsigned long long>(first));
  return folder + "/" + name + kSuffix;
}

/// First numbers of the segments that are there, rising.
std::deque<std::uint64_t> SegmentsIn(const std::string& folder) {
  std::deque<std::uint64_t> firsts;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(kSuffix)) continue;
    const std::string number = name.substr(0, name.size() - std::strlen(kSuffix));
    if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) continue;
    firsts.push_back(std::stoull(number));
  }
  std::sort(firsts.begin(), firsts.end());
  return firsts;
}

template <typename Entries>
std::string DigestOf(const Entries& entries) {
  std::string bytes;
  for (const auto& [number, checksum] : entries) {
    Put(bytes, number);
    Put(bytes, checksum);
  }
  return process::Sha256Hex(bytes);
}

using Checksums = std::vector<std::pair<std::uint64_t, std::uint32_t>>;

/// Reads a segment's episodes from number `first` to the one before `next`.
void ReadSegment(const std::string& path, std::uint64_t first, std::uint64_t next,
                 std::vector<Episode>& episodes, Checksums& checksums) {
  const std::string content = process::ReadFile(path);
  for (std::size_t at = 0; at < content.size();) {
    const auto record = RecordAt(std::string_view(content).substr(at));
    const auto episode = record ? EpisodeOf(record->payload) : std::nullopt;
    if (!episode) {
      throw ReplayDamaged(path + ": damaged at byte " + std::to_string(at));
    }
    at += kHead + record->payload.size();
    if (episode->number >= next) return;
    if (episode->number < first) continue;
    checksums.emplace_back(episode->number, record->checksum);
    episodes.push_back(*episode);
    if (episode->number + 1 == next) return;  // what comes later may be torn
  }
}

}  // namespace

std::vector<Episode> EpisodeLog::Read(const std::string& run_folder,
                                      const checkpoint::ReplayPosition& position) {
  const std::string folder = run_folder + "/replay";
  std::vector<Episode> episodes;
  if (position.next == position.first) return episodes;
  Checksums checksums;
  const std::deque<std::uint64_t> segments = SegmentsIn(folder);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool before = i + 1 < segments.size() && segments[i + 1] <= position.first;
    if (before || segments[i] >= position.next) continue;
    ReadSegment(SegmentPath(folder, segments[i]), position.first, position.next, episodes,
                checksums);
  }
  const std::string wanted = "episodes " + std::to_string(position.first) + " to " +
                             std::to_string(position.next) + " (the last one left out)";
  if (episodes.size() != position.next - position.first) {
    throw ReplayDamaged(folder + " holds " + std::to_string(episodes.size()) + " of the " +
                        std::to_string(position.next - position.first) +
                        " episodes that the checkpoint's replay has, " + wanted);
  }
  if (DigestOf(checksums) != position.sha256) {
    throw ReplayDamaged(folder + " holds other " + wanted + " than the checkpoint's replay has");
  }
  return episodes;
}

EpisodeLog::EpisodeLog(const std::string& run_folder, const checkpoint::ReplayPosition& position,
                       std::uint64_t most_steps, std::uint64_t checkpoints)
    : folder_(run_folder + "/replay"),
      most_steps_(most_steps),
      checkpoints_(checkpoints),
      next_(position.next) {
  fs::create_directories(folder_);
  for (const Episode& episode : Read(run_folder, position)) {
    entries_.push_back(
        {episode.number, Crc32c(PayloadOf(episode)), std::uint32_t(episode.reward.size())});
    steps_ += episode.reward.size();
  }
  segments_ = SegmentsIn(folder_);
  while (!segments_.empty() && segments_.back() >= next_) {
    fs::remove(SegmentPath(folder_, segments_.back()));
    segments_.pop_back();
  }
  if (segments_.empty()) return;
  const std::string path = SegmentPath(folder_, segments_.back());
  OpenSegment(segments_.back(), BytesBefore(process::ReadFile(path), next_));
}

EpisodeLog::~EpisodeLog() = default;

void EpisodeLog::OpenSegment(std::uint64_t first, std::uint64_t keep_bytes) {
  file_ = std::make_unique<RecordFile>(SegmentPath(folder_, first), keep_bytes,
                                       [](std::string_view content) { return content.size(); });
}

void EpisodeLog::Append(const std::vector<Episode>& batch) {
  const bool lost_before = lost_;
  lost_ = true;  // until all of the batch is in a file or waits: a segment may not open
  bool all_kept = true;
  // What waits for room stays with its file.
  if (!batch.empty() && (!file_ || (file_->size() >= kSegmentBytes && file_->Sync()))) {
    segments_.push_back(batch.front().number);
    OpenSegment(batch.front().number, 0);
  }
  for (const Episode& episode : batch) {
    const std::string payload = PayloadOf(episode);
    const std::uint32_t checksum = Crc32c(payload);
    std::string record;
    Put(record, std::uint32_t(payload.size()));
    Put(record, checksum);
    all_kept = file_->Append(record + payload) && all_kept;
    entries_.push_back({episode.number, checksum, std::uint32_t(episode.reward.size())});
    steps_ += episode.reward.size();
    next_ = episode.number + 1;
  }
  lost_ = lost_before || !all_kept;
  Forget();
}

// As the replay forgets (learner/sac/replay.h): the oldest that leave no room for the newest.
void EpisodeLog::Forget() {
  while (steps_ > most_steps_ && entries_.size() > 1) {
    steps_ -= entries_.front().steps;
    entries_.pop_front();
  }
}

bool EpisodeLog::Sync() {
  if (!lost_) return !file_ || file_->Sync();
  errno = ENOSPC;
  return false;
}

checkpoint::ReplayPosition EpisodeLog::position() const {
  Checksums checksums;
  for (const Entry& entry : entries_) checksums.emplace_back(entry.number, entry.checksum);
  return {entries_.empty() ? next_ : entries_.front().number, next_, DigestOf(checksums)};
}

void EpisodeLog::Saved() {
  needed_.push_back(entries_.empty() ? next_ : entries_.front().number);
  if (needed_.size() < checkpoints_) return;  // there may be older ones, of an earlier start
  if (needed_.size() > checkpoints_) needed_.pop_front();
  while (segments_.size() > 1 && segments_[1] <= needed_.front()) {
    std::error_code kept;  // it is tried again next time
    if (!fs::remove(SegmentPath(folder_, segments_.front()), kept) && kept) return;
    segments_.pop_front();
  }
}

}  // namespace metronome::record
