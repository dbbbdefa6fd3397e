"""A run read by the DDS of another maker, from nothing but the IDL and what idl/README.md says."""

import re
import signal
import subprocess

import pytest

import environments
from harness import ENDLESS, EPISODES, ROOT, UPDATES, parse_json

HERE = ROOT / "tests" / "integration" / "cyclone"
IDL = ROOT / "idl" / "metronome.idl"
# Cyclone's Python counts the bounds of sequences in 16 bits. They are not part of what is sent.
LONG_BOUND = re.compile(r"(sequence\[[\w.]+), \d{5,}\]")
FINISHED, STOPPED = 3, 4


@pytest.fixture(scope="module")
def python():
    return environments.python("cyclone", HERE / "requirements.txt") / "bin" / "python"


@pytest.fixture(scope="module")
def types(tmp_path_factory):
    """The folder of the Python types that Cyclone's compiler makes of the IDL."""
    home = environments.unpacked("cyclone-idlc", HERE / "idlc.txt", "3.10") / "cyclonedds"
    (backend,) = home.glob("_idlpy.*.so")
    folder = tmp_path_factory.mktemp("types")
    subprocess.run([home / ".libs" / "idlc", "-l", backend, IDL], cwd=folder, check=True, timeout=60)
    (made,) = folder.glob("metronome/wire/_metronome.py")
    made.write_text(LONG_BOUND.sub(r"\1]", made.read_text()))
    return folder


@pytest.fixture
def tap(stage, python, types):
    def start(run):
        configured = f"CYCLONEDDS_URI=file://{HERE / 'loopback.xml'}"
        return stage.start("env", configured, python, "-B", HERE / "tap.py", types, stage.domain, run)

    return start


def said(tap, key):
    """@return what the tap has said so far that has `key`."""
    return [said for said in map(parse_json, list(tap.output)) if key in said]


def expect_peers(tap, *topics):
    for topic in topics:
        tap.expect(
            lambda line, topic=f"metronome/{topic}": parse_json(line).get("topic") == topic
            and parse_json(line)["writers"] > 0,
            f"a writer of {topic}",
        )


def expect_state(tap, state):
    return tap.expect(
        lambda line: parse_json(line) if parse_json(line).get("state") == state else None,
        f"state {state}",
    )


def expect_snapshot(tap, version):
    return tap.expect(
        lambda line: parse_json(line) if parse_json(line).get("snapshot", -1) >= version else None,
        f"snapshot {version}",
    )


def returns_of(episodes):
    """@return mean sum of rewards of each version's episodes, by version; each episode once."""
    batches = {}
    for episode in {episode["episode"]: episode for episode in episodes}.values():
        batches.setdefault(episode["version"], []).append(episode["rewards"])
    return {version: sum(rewards) / len(rewards) for version, rewards in batches.items()}


@pytest.mark.slow
def test_cyclone_dds_sees_every_episode_once_and_every_float_and_the_run_does_not_notice(stage, tap):
    reader = tap("tapped")
    actor = stage.actor("tapped")  # before the learner, so that it plays nothing unseen
    expect_peers(reader, "episode")
    # A run of a second may be over before the reader knows of it. With an audit and one actor the learner
    # waits five seconds for another one.
    learner = stage.learner("tapped", "--audit", 1)
    expect_peers(reader, "policy_snapshot", "learner_status")
    weights = stage.finish("tapped", learner, [actor])

    status = expect_state(reader, FINISHED)
    assert (status["run"], status["version"]) == ("tapped", UPDATES)
    assert status["actors"][0].endswith(f":{actor.child.pid}")

    last = expect_snapshot(reader, UPDATES)
    assert last["snapshot"] == UPDATES and last["checksum"] == last["computed"]

    count = EPISODES * UPDATES
    for number in range(count):
        reader.expect(lambda line: parse_json(line).get("episode") == number, f"episode {number}")
    episodes = said(reader, "episode")
    reassigned = int(re.search(r"reassigned (\d+)", learner.text)[1])
    assert len(episodes) <= count + reassigned
    told = [line for line in map(parse_json, learner.output) if "return" in line]
    assert returns_of(episodes) == {
        update["update"] - 1: pytest.approx(update["return"], rel=1e-6) for update in told
    }

    assert stage.train("untapped") == weights


@pytest.mark.slow
def test_who_comes_late_gets_the_last_weights_and_what_is_played_from_then_on(stage, tap):
    learner = stage.learner("late", small=ENDLESS)
    actors = [stage.actor("late") for _ in range(2)]
    learner.expect_update(3)
    reader = tap("late")
    expect_peers(reader, "policy_snapshot", "learner_status", "episode")
    first = expect_snapshot(reader, 0)
    assert first["snapshot"] >= 2 and first["checksum"] == first["computed"]
    reader.expect(lambda line: "episode" in parse_json(line), "an episode")
    learner.signal(signal.SIGINT)
    assert learner.wait() == 130
    assert len(expect_state(reader, STOPPED)["actors"]) == len(actors)
