"""Cores that the launcher counts with: affinity and the CPU quotas of cgroups."""

import os

import pytest

import cores
import options

V2 = "29 1 0:26 / /sys/fs/cgroup rw,nosuid shared:4 - cgroup2 cgroup2 rw,nsdelegate\n"
V1 = "33 1 0:30 {inside} /sys/fs/cgroup/cpu,cpuacct rw shared:9 - cgroup cgroup rw,cpu,cpuacct\n"
OTHERS = "25 1 0:24 / /sys rw - sysfs sysfs rw\n34 1 0:31 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n"


@pytest.fixture
def machine(tmp_path):
    """Makes a root folder: our cgroups, the mounts, and files below /sys/fs/cgroup."""

    def make(ours, mounts, **files):
        (tmp_path / "proc" / "self").mkdir(parents=True)
        (tmp_path / "proc" / "self" / "cgroup").write_text(ours)
        (tmp_path / "proc" / "self" / "mountinfo").write_text(OTHERS + mounts)
        for name, text in files.items():
            path = tmp_path / "sys/fs/cgroup" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text + "\n")
        return tmp_path

    return make


def test_without_cgroups_there_is_no_quota(tmp_path):
    assert cores.quota(tmp_path) is None
    assert cores.usable(tmp_path) == len(os.sched_getaffinity(0))


@pytest.mark.parametrize("files, quota", [
    ({"a/b/cpu.max": "150000 100000"}, 1.5),
    ({"a/b/cpu.max": "max 100000"}, None),
    ({"a/b/cpu.max": "max 100000", "a/cpu.max": "50000 100000"}, 0.5),
    ({"a/b/cpu.max": "300000 100000", "a/cpu.max": "200000 100000"}, 2.0),
    ({"c/cpu.max": "50000 100000"}, None),
    ({"a/b/cpu.max": "not what it was"}, None),
])
def test_the_narrowest_quota_up_the_hierarchy_counts(machine, files, quota):
    assert cores.quota(machine("0::/a/b\n", V2, **files)) == quota


@pytest.mark.parametrize("inside, path", [("/", "/a/b"), ("/docker", "/docker/a/b")])
def test_the_first_version_counts_too(machine, inside, path):
    root = machine(f"3:memory:/other\n2:cpu,cpuacct:{path}\n0::/\n", V1.format(inside=inside), **{
        "cpu,cpuacct/a/b/cpu.cfs_quota_us": "-1", "cpu,cpuacct/a/b/cpu.cfs_period_us": "100000",
        "cpu,cpuacct/a/cpu.cfs_quota_us": "250000", "cpu,cpuacct/a/cpu.cfs_period_us": "100000"})
    assert cores.quota(root) == 2.5


def test_a_container_that_sees_its_cgroup_as_the_outermost_has_its_quota(machine):
    root = machine("2:cpu,cpuacct:/docker/0123\n", V1.format(inside="/docker/4567"), **{
        "cpu,cpuacct/cpu.cfs_quota_us": "50000", "cpu,cpuacct/cpu.cfs_period_us": "100000"})
    assert cores.quota(root) == 0.5


@pytest.mark.parametrize("limit, affinity, usable", [(0.1, 8, 1), (1.5, 8, 2), (3.0, 2, 2), (None, 8, 8)])
def test_usable_cores_are_whole_and_at_least_one(monkeypatch, limit, affinity, usable):
    monkeypatch.setattr(cores, "quota", lambda root: limit)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(affinity)))
    assert cores.usable() == usable


@pytest.mark.parametrize("words, says", [
    ((), None),
    (("--actors", "2"), None),
    (("--actors", "0", "--envs", "9"), None),
    (("--actors", "2", "--envs", "2"), "4 episodes at once (--actors times --envs) on 2 cores (CPU quota 1.5)"),
    (("--set", "runtime.learner_threads=64"), "64 threads of the learner on 2 cores"),
])
def test_more_than_the_cores_carry_is_warned_of(monkeypatch, tmp_path, words, says):
    monkeypatch.setattr(cores, "quota", lambda root="/": 1.5)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    asked = options.parse(["push", "--runs", str(tmp_path), *words])
    warning = options.warning(asked)
    assert warning is None if says is None else says in warning
