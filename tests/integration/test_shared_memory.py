"""A small /dev/shm, as containers have it: what fits runs, what does not is refused by name at its start."""

import contextlib
import signal

import pytest

import namespaces
from harness import ENDLESS, parse_json

SHM = ("--transport", "shm")
WAYS_OUT = ("--shm-size", "start fewer processes", "fastdds shm clean")
EMPTY_DEV = (
    "mount -t tmpfs dev /dev",
    *(f"mknod -m 666 /dev/{node}" for node in ("null c 1 3", "urandom c 1 9")),
)

pytestmark = pytest.mark.skipif(
    namespaces.mounts_unavailable() is not None, reason=str(namespaces.mounts_unavailable())
)


@contextlib.contextmanager
def machine(size, *more):
    """@param size  of its /dev/shm, as mount understands it."""
    mounts = namespaces.Mounts(f"mount -t tmpfs -o size={size} shm /dev/shm", *more)
    try:
        yield mounts
    finally:
        mounts.close()


def files_of(mounts):
    return set(mounts.run("ls", "/dev/shm").split())


def assert_refused(process, *words):
    assert process.wait(30) == 2, process
    for word in (*words, "--transport udp needs none"):
        assert word in process.text, process


@pytest.mark.slow
def test_a_learner_two_actors_and_a_status_fit_into_64_mb_and_give_the_same_weights(stage):
    expected = stage.train("calm")
    with machine("64m") as small:
        learner = stage.learner("run", *SHM, host=small)
        learner.expect_event("started")
        status = stage.status("run", "--follow", *SHM, host=small)
        status.expect(parse_json, "the learner's first status")
        team = [stage.actor("run", *SHM, host=small) for _ in range(2)]
        assert stage.finish("run", learner, team) == expected
        assert status.wait(30) == 0, status
        assert not files_of(small)


@pytest.mark.slow
def test_of_actors_that_start_at_once_those_run_that_fit_and_the_others_are_refused(stage):
    with machine("64m") as small:
        learner = stage.learner("run", *SHM, small=ENDLESS, host=small)
        learner.expect_event("started")
        team = [stage.actor("run", *SHM, host=small) for _ in range(5)]
        for actor in team:
            actor.expect(lambda line: "joined run" in line or "no shared memory" in line, "its fate")
        refused = [actor for actor in team if "no shared memory" in actor.text]
        assert len(refused) == 3
        for actor in refused:
            assert_refused(actor, "/dev/shm has room for", "needs 17 MB", *WAYS_OUT)
        learner.expect_update(learner.updates() + 5)
        learner.signal(signal.SIGINT)
        assert learner.wait() == 130, learner


def test_who_takes_the_place_of_a_killed_actor_waits_for_its_room(stage):
    with machine("52m") as small:
        stage.learner("run", *SHM, small=ENDLESS, host=small)
        team = [stage.actor("run", *SHM, host=small) for _ in range(2)]
        for actor in team:
            actor.expect_text("joined run")
        # Like the learner, which maps the memory of a dead one for up to some seconds.
        note = f"/dev/shm/metronome-{stage.domain}-run-{team[0].child.pid}-1"
        (segment,) = (n for n in small.run("cat", note).split() if is_segment(n))
        peer = stage.start("sleep", "infinity", host=Holding(small, f"/dev/shm/{segment}"))
        peer.expect_text("held")
        team[0].kill()
        newcomer = stage.actor("run", *SHM, host=small)
        newcomer.expect_text("waiting for the peers of the killed to let go of /dev/shm")
        peer.kill()
        newcomer.expect_text("joined run")


class Container:
    """Process ids of its own in what `mounts` has: its first process is 1 there."""

    def __init__(self, mounts):
        self._mounts = mounts

    def process(self, *command):
        return self._mounts.process("unshare", "--pid", "--fork", "--kill-child", *command)


@pytest.mark.slow
def test_containers_that_share_it_may_have_the_same_process_ids(stage):
    expected = stage.train("calm")
    with machine("128m") as small:
        learner = stage.learner("run", *SHM, host=Container(small))
        learner.expect_event("started")
        team = [stage.actor("run", *SHM, host=Container(small)) for _ in range(2)]
        for actor in team:
            actor.expect_text("joined run")
        assert stage.finish("run", learner, team) == expected
        assert not files_of(small)


class Holding:
    """Processes of `mounts` that have a file open, which they tell."""

    def __init__(self, mounts, path):
        self._mounts, self._path = mounts, path

    def process(self, *command):
        script = 'exec 3< "$0" && echo held && exec "$@"'
        return self._mounts.process("sh", "-c", script, self._path, *command)


def is_segment(name):
    return name.startswith("fastrtps_") and "port" not in name and not name.endswith("_el")


@pytest.mark.parametrize("size", [16, 32])
def test_without_room_for_a_learner_and_an_actor_no_run_begins(stage, size):
    with machine(f"{size}m") as small:
        learner = stage.learner("run", *SHM, host=small)
        words = f"/dev/shm has room for {size} MB, this process and an actor need 34 MB"
        assert_refused(learner, words, *WAYS_OUT)
        assert not (stage.runs / "run").exists()
        assert not files_of(small)


@pytest.mark.slow
def test_where_an_actor_waits_already_a_learner_needs_no_more_than_its_own_room(stage):
    with machine("36m") as small:
        actor = stage.actor("run", *SHM, host=small)
        actor.expect_text("no learner for run")
        stage.finish("run", stage.learner("run", *SHM, host=small), [actor])


def test_what_other_people_keep_there_counts(stage):
    full = "head -c 50M /dev/zero > /dev/shm/theirs"
    with machine("64m", full) as small:
        assert_refused(stage.actor("run", *SHM, host=small), "/dev/shm has room for 14 MB")
        assert files_of(small) == {"theirs"}


def test_a_folder_that_cannot_be_written_is_named(stage):
    with machine("64m", "mount -o remount,ro /dev/shm") as small:
        for process in (
            stage.learner("run", *SHM, host=small),
            stage.actor("run", *SHM, host=small),
            stage.status("run", *SHM, host=small),
        ):
            assert_refused(process, "/dev/shm/metronome-", "Read-only file system")


def test_a_process_whose_memory_is_taken_away_says_so_and_dies_of_it(stage):
    with machine("64m") as small:
        learner = stage.learner("run", *SHM, small=ENDLESS, host=small)
        learner.expect_event("started")
        actor = stage.actor("run", *SHM, host=small)
        learner.expect_update(1)
        for name in files_of(small):
            small.run("truncate", "-s", "0", f"/dev/shm/{name}")
        for process in (learner, actor):
            assert process.wait(30) == -signal.SIGBUS, process
            process.expect_text("SIGBUS: memory that is mapped from a file is not there")


def test_a_folder_that_is_not_there_is_named(stage):
    with machine("64m", *EMPTY_DEV) as small:
        actor = stage.actor("run", *SHM, host=small)
        assert_refused(actor, "/dev/shm: No such file or directory")


def test_a_folder_that_is_elsewhere_is_cleaned_too(stage, tmp_path):
    elsewhere = tmp_path / "shm"
    elsewhere.mkdir()
    with machine("64m", *EMPTY_DEV, f"ln -s {elsewhere} /dev/shm") as small:
        learner = stage.learner("run", *SHM, host=small)
        learner.expect_event("started")
        learner.kill()
        again = stage.learner("run", "--resume", *SHM, host=small)
        again.expect_event("started")
        again.expect_text("removed 5 shared-memory files that 1 killed process of this run left")
        again.signal(signal.SIGINT)
        again.wait()
        assert not list(elsewhere.iterdir())


@pytest.mark.slow
def test_udp_and_tcp_do_not_need_it(stage):
    for transport in ("udp", "tcp"):
        with machine("64m", "mount -o remount,ro /dev/shm") as small:
            way = ("--transport", transport)
            learner = stage.learner(transport, *way, host=small)
            actor = stage.actor(transport, *way, host=small)
            stage.finish(transport, learner, [actor])


def test_what_a_process_left_that_died_before_it_noted_its_files_is_removed(stage):
    with machine("64m") as small:
        other = stage.learner("other", *SHM, host=small)
        other.expect_event("started")
        other.kill()
        theirs = files_of(small)
        small.run("touch", "/dev/shm/before")
        learner = stage.learner("run", *SHM, host=small)
        learner.expect_event("started")
        learner.kill()
        forget_segments(small, stage.domain)
        again = stage.learner("run", "--resume", *SHM, host=small)
        again.expect_event("started")
        again.expect_text("removed 5 shared-memory files that 1 killed process of this run left")
        again.signal(signal.SIGINT)
        again.wait()
        assert files_of(small) == theirs


def forget_segments(mounts, domain):
    """Makes the note of run `run` what it is while the participant is being made."""
    (name,) = (n for n in files_of(mounts) if n.startswith(f"metronome-{domain}-run-"))
    note = f"/dev/shm/{name}"
    ports = "".join(f"{line}\n" for line in mounts.run("cat", note).split() if "port" in line)
    mounts.run("sh", "-c", 'printf %s "$1" > "$0" && touch -r /dev/shm/before "$0"', note, ports)
    mounts.run("rm", "/dev/shm/before")
