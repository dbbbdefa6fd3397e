#pragma once

#include <cstddef>
#include <string_view>

namespace metronome::watch {

/// Until version 0.1 some numbers had other names. Dashboards and scripts that know only those
/// still find them. Names as METRONOME_RUN_NUMBERS and METRONOME_ACTOR_NUMBERS have them.
struct OldName {
  std::string_view name;
  const char* old_name;    // in JSON
  const char* old_metric;  // in Prometheus
};

inline constexpr OldName kOldRunNames[] = {
    {"idle_share", nullptr, "metronome_slots_idle_ratio"},
    {"reassigned", "reordered", "metronome_episodes_reordered_total"},
    {"envs_total", "slots_total", "metronome_slots"},
};

inline constexpr OldName kOldActorNames[] = {
    {"envs", "slots", "metronome_actor_slots"},
    {"assignments", "orders", "metronome_actor_orders"},
    {"oldest_assignment_seconds", "oldest_order_seconds",
     "metronome_actor_oldest_order_age_seconds"},
};

/// @return the row of `names` for a number, or nullptr if it never had another name.
template <std::size_t N>
const OldName* FindOldName(const OldName (&names)[N], std::string_view name) {
  for (const OldName& row : names) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

}  // namespace metronome::watch
