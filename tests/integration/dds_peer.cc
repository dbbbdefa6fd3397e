#include <cstdlib>

#include "common/dds/dds_bus.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::test {
namespace {

int Serve(const BusOptions& options, std::uint64_t actor_id) {
  const auto bus = dds::MakeDdsActorBus(options, actor_id);
  const auto end = Clock::now() + std::chrono::minutes(2);  // no test lasts as long
  for (std::uint64_t number = 0; Clock::now() < end; ++number) {
    bus->Send(SomeStatus(actor_id));
    (void)bus->Send(SomeEpisode(number));
    const auto event = bus->Wait(Clock::now() + std::chrono::milliseconds(100));
    const auto* assignment = event ? std::get_if<EpisodeAssignment>(&*event) : nullptr;
    if (assignment != nullptr) (void)bus->Send(SomeEpisode(assignment->numbers.front()));
  }
  return 0;
}

}  // namespace
}  // namespace metronome::test

/// An actor in a process of its own, to be killed: says hello every 100 ms and answers assignments
/// until then. dds_peer RUN DOMAIN udp|shm ACTOR_ID
int main(int argc, char** argv) {
  if (argc != 5) return 2;
  metronome::BusOptions options;
  options.run_name = argv[1];
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[2]));
  options.transport = metronome::ParseTransport(argv[3]);
  return metronome::test::Serve(options, std::strtoull(argv[4], nullptr, 10));
}
