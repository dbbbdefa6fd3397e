"""Reads a run with Cyclone DDS, a DDS of another maker. Of Metronome it knows what idl/ says, and no more.

    CYCLONEDDS_URI=file://PATH/loopback.xml tap.py TYPES DOMAIN RUN

by a Python that has the package cyclonedds; TYPES is the folder of what Cyclone's compiler made of
idl/metronome.idl. Prints a JSON object for each sample and each change of peers, until it is ended.
"""

import json
import struct
import sys
import zlib

from cyclonedds.core import (
    InstanceState,
    Listener,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic
from cyclonedds.util import duration

sys.path.insert(0, sys.argv[1])
from metronome import wire  # noqa: E402

TOPICS = {
    "metronome/policy_snapshot": (wire.PolicySnapshot, Policy.Durability.TransientLocal),
    "metronome/episode": (wire.Episode, Policy.Durability.Volatile),
    "metronome/learner_status": (wire.LearnerStatus, Policy.Durability.TransientLocal),
}
UNREAD = SampleState.NotRead | ViewState.Any | InstanceState.Any


def say(**fields):
    print(json.dumps(fields), flush=True)


class Peers(Listener):
    def __init__(self, topic):
        super().__init__()
        self._topic = topic

    def on_subscription_matched(self, _reader, status):
        say(topic=self._topic, writers=status.current_count)


def checksum(snapshot):
    """CRC-32 of version and the three arrays, little-endian: as the IDL says."""
    crc = zlib.crc32(struct.pack("<Q", snapshot.version))
    for array in (snapshot.parameters, snapshot.observation_mean, snapshot.observation_inv_std):
        crc = zlib.crc32(struct.pack(f"<{len(array)}f", *array), crc)
    return crc


def tell(sample):
    if isinstance(sample, wire.Episode):
        say(episode=sample.number, version=sample.weights_version, rewards=sum(sample.reward))
    elif isinstance(sample, wire.PolicySnapshot):
        say(snapshot=sample.version, checksum=sample.checksum, computed=checksum(sample))
    elif isinstance(sample, wire.LearnerStatus):  # else a writer has left
        names = [actor.name for actor in sample.actors]
        say(run=sample.run_name, state=sample.state, version=sample.version, actors=names)


def read(participant, subscriber, topic):
    kind, durability = TOPICS[topic]
    quality = Qos(
        Policy.Reliability.Reliable(duration(seconds=1)),
        Policy.History.KeepAll,
        Policy.DataRepresentation(use_cdrv0_representation=True),  # XCDR1
        durability,
    )
    return DataReader(subscriber, Topic(participant, topic, kind), qos=quality, listener=Peers(topic))


def main():
    domain, run = int(sys.argv[2]), sys.argv[3]
    participant = DomainParticipant(domain)
    subscriber = Subscriber(participant, Qos(Policy.Partition([run])))
    readers = [read(participant, subscriber, topic) for topic in TOPICS]
    news = WaitSet(participant)
    for reader in readers:
        news.attach(ReadCondition(reader, UNREAD))
    say(ready=run)
    while True:
        news.wait(duration(infinite=True))
        for reader in readers:
            for sample in reader.take(100):
                tell(sample)


main()
