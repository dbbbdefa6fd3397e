#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "common/messages/messages.h"

namespace metronome::watch {

/// A learner's metrics for Prometheus: `metronome_...`, in base units, every series with the
/// label `run`, those of an actor with `actor` (host:pid) and `host` too. Who is not in `status`
/// has none. Pure.
/// @param made_at  when `status` was made, Unix time in seconds.
std::vector<prometheus::MetricFamily> PrometheusMetrics(const LearnerStatus& status,
                                                        double made_at);

}  // namespace metronome::watch
