#include <cstdlib>
#include <iostream>

#include "common/dds/dds_bus.h"
#include "tests/integration/dds_fixture.h"

/// An actor in a process of its own, to be killed: says hello every 100 ms and
/// answers orders until then.
/// dds_peer RUN DOMAIN udp|shm ACTOR_ID
int main(int argc, char** argv) {
  using namespace metronome;
  if (argc != 5) return 2;
  BusOptions options;
  options.run_name = argv[1];
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[2]));
  options.transport = ParseTransport(argv[3]);
  const std::uint64_t actor_id = std::strtoull(argv[4], nullptr, 10);
  const auto bus = MakeDdsActorBus(options, actor_id);
  const auto end = Clock::now() + std::chrono::minutes(2);  // no test lasts as long
  for (std::uint64_t number = 0; Clock::now() < end; ++number) {
    bus->Send(test::SomeStatus(actor_id));
    (void)bus->Send(test::SomeEpisode(number));
    const auto event = bus->Wait(Clock::now() + std::chrono::milliseconds(100));
    const auto* order = event ? std::get_if<EpisodeOrder>(&*event) : nullptr;
    if (order != nullptr) (void)bus->Send(test::SomeEpisode(order->numbers.front()));
  }
  return 0;
}
