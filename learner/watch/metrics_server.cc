#include "learner/watch/metrics_server.h"

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/process/mutex.h"
#include "learner/watch/prometheus_metrics.h"

namespace metronome::watch {

class MetricsServer::Latest final : public prometheus::Collectable {
 public:
  void Set(std::vector<prometheus::MetricFamily> families) {
    const process::MutexLock lock(mutex_);
    families_ = std::move(families);
  }
  [[nodiscard]] std::vector<prometheus::MetricFamily> Collect() const override {
    const process::MutexLock lock(mutex_);
    return families_;
  }

 private:
  mutable process::Mutex mutex_;
  std::vector<prometheus::MetricFamily> families_ METRONOME_GUARDED_BY(mutex_);
};

MetricsServer::MetricsServer(const text::ListenAddress& address)
    : latest_(std::make_shared<Latest>()) {
  try {
    exposer_ = std::make_unique<prometheus::Exposer>(address.Text());
  } catch (const std::exception&) {  // says nothing of use
    throw std::invalid_argument("--metrics: nothing can listen at " + address.Text() +
                                ": the port is in use, or the address is not this machine's; name "
                                "another one, or port 0 for any that is free");
  }
  exposer_->RegisterCollectable(latest_);
  spdlog::info("metrics for Prometheus at http://{}:{}/metrics", address.host,
               exposer_->GetListeningPorts().at(0));
}

MetricsServer::~MetricsServer() = default;

void MetricsServer::Show(const LearnerStatus& status) {
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  latest_->Set(PrometheusMetrics(status, now.count()));
}

}  // namespace metronome::watch
