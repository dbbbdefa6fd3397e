#pragma once

#include <memory>

#include "common/messages/messages.h"
#include "common/text/listen_address.h"

namespace prometheus {
class Exposer;
}

namespace metronome::watch {

/// Serves a learner's latest status at http://ADDRESS/metrics, in Prometheus' format, by threads of
/// its own. Thread-safe.
class MetricsServer {
 public:
  /// Listens from here on; nothing is shown before the first status.
  /// @throws std::invalid_argument if nothing can listen at `address`; names it.
  explicit MetricsServer(const text::ListenAddress& address);
  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  void Show(const LearnerStatus& status);

 private:
  class Latest;
  std::shared_ptr<Latest> latest_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace metronome::watch
