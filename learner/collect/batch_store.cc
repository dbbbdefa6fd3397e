#include "learner/collect/batch_store.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace metronome::collect {
BatchStore::BatchStore(std::uint64_t episodes_per_update, std::uint64_t updates_before)
    : episodes_per_update_(episodes_per_update),
      entered_(updates_before * episodes_per_update, 1),
      before_(entered_.size()) {}

void BatchStore::Put(Episode episode) {
  const std::uint64_t number = episode.number;
  if (!making_.emplace(number, std::move(episode)).second) {
    throw std::logic_error("episode " + std::to_string(number) + " is there already");
  }
}

const Episode* BatchStore::Find(std::uint64_t number) const {
  const auto making = making_.find(number);
  if (making != making_.end()) return &making->second;
  if (taken_ == nullptr || taken_->empty() || number < taken_->front().number) return nullptr;
  const std::uint64_t index = number - taken_->front().number;
  return index < taken_->size() ? &(*taken_)[index] : nullptr;
}

std::optional<Episode> BatchStore::Withdraw(std::uint64_t number) {
  auto entry = making_.extract(number);
  if (entry.empty()) return std::nullopt;
  return std::move(entry.mapped());
}

BatchStore::Batch BatchStore::Take(std::uint64_t version) {
  std::vector<Episode> batch;
  batch.reserve(episodes_per_update_);
  const std::uint64_t first = version * episodes_per_update_;
  for (std::uint64_t number = first; number < first + episodes_per_update_; ++number) {
    auto entry = making_.extract(number);
    if (entry.empty()) {
      throw std::logic_error("episode " + std::to_string(number) + " of the batch is missing");
    }
    batch.push_back(std::move(entry.mapped()));
  }
  taken_ = std::make_shared<const std::vector<Episode>>(std::move(batch));
  return taken_;
}

void BatchStore::CountEntered(const std::vector<Episode>& batch) {
  for (const Episode& episode : batch) {
    if (episode.number >= entered_.size()) entered_.resize(episode.number + 1, 0);
    ++entered_[episode.number];
  }
}

BatchStore::Accounting BatchStore::Account(std::uint64_t updates) const {
  Accounting accounting;
  accounting.total = updates * episodes_per_update_;
  accounting.once = static_cast<std::uint64_t>(std::count(entered_.begin(), entered_.end(), 1U));
  accounting.entered = entered_.size() -
                       static_cast<std::uint64_t>(std::count(entered_.begin(), entered_.end(), 0U));
  accounting.before_resume = before_;
  return accounting;
}

}  // namespace metronome::collect
