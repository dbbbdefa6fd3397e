#pragma once

#include <chrono>
#include <cstdint>

/// Care for Fast DDS 2.9's TCP connections, which it lacks itself, by their sockets.
namespace metronome::dds::workarounds {

/// To be called once the learner's participant is made. Fast DDS writes to sockets in blocking
/// calls; a peer whose machine is gone, or that is stopped, would hold the learner up for as long
/// as the system goes on trying (a quarter of an hour). So connections end after `lease`
/// without an answer.
/// @throws std::runtime_error if this process does not listen on `port`: Fast DDS only logs that.
void EndSilentConnections(std::uint16_t port, std::chrono::milliseconds lease);

/// To be called once a participant is made that connects to the learner's `port`. Fast DDS 2.9
/// connects and only then notes which port it wants inside the connection
/// (TCPTransportInterface::OpenOutputChannel). If this thread is held up in between, the learner's
/// greeting comes too early and is dropped, and nothing is ever sent over that connection. It is
/// cut here, and the next announcement makes another, by when the port is noted. Seen once in 150
/// joins.
void CutMuteConnections(std::uint16_t port);

/// To be called before the learner's participant is deleted, once its endpoints are. Fast DDS 2.9
/// notes whether its receiver is in use in one bit for all connections: if two threads have just
/// read something, the second one writes to what was deleted when the first was done
/// (TCPTransportInterface::CloseInputChannel, perform_listen_operation), and the heap is spoiled;
/// seen twice in 10 ends with eight actors. So the port and its connections are closed first, and
/// their threads are waited for, which takes milliseconds; 5 s at most, since one socket was once
/// not closed by Fast DDS (under valgrind).
void EndConnections(std::uint16_t port);

}  // namespace metronome::dds::workarounds
