"""The Containerfile: what it copies exists and is enough, what it links and the manifest starts is in the package.

No image is built here. tests/fresh/package installs the package. By hand, before the image had the package, Buildah 1.28 built both
stages (chroot isolation, on a minimal `bookworm` made by debootstrap) and ran a learner and an actor as user 10001. Not tried: the
official base image, Docker, `podman run`, a read-only root."""

import re
import shlex
import subprocess

import pytest

from harness import BUILD, ROOT

TEXT = (ROOT / "deploy" / "Containerfile").read_text()
MANIFEST = (ROOT / "deploy" / "kubernetes" / "metronome.yaml").read_text()


def stages():
    """The instructions of each stage, as lists of words."""
    joined = re.sub(r"\\\n", " ", re.sub(r"^#.*\n", "", TEXT, flags=re.MULTILINE))
    found = []
    for line in filter(None, map(str.strip, joined.splitlines())):
        words = shlex.split(line)
        if words[0] == "FROM":
            found.append([])
        found[-1].append(words)
    return found


def copied():
    """What the build stage copies."""
    return {source for words in stages()[0] if words[0] == "COPY" for source in words[1:-1]}


def links():
    """{link: target} of every ln -s of the image."""
    return {link: target for target, link in re.findall(r"ln -s (\S+) (\S+)", TEXT)}


@pytest.fixture(scope="module")
def packaged(tmp_path_factory):
    """Paths of the files that the package puts into the image."""
    prefix = tmp_path_factory.mktemp("usr")
    subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], check=True, capture_output=True)
    return {f"/usr/{path.relative_to(prefix)}" for path in prefix.rglob("*")}


def test_it_copies_what_the_checkout_has():
    for source in copied():
        assert (ROOT / source).exists(), source


def test_the_build_stage_has_all_that_set_up_compiles_and_packs():
    cmake, install = ((ROOT / name).read_text() for name in ("CMakeLists.txt", "deploy/CMakeLists.txt"))
    needed = {"CMakeLists.txt", "CMakePresets.json", "deploy", *re.findall(r"^add_subdirectory\((\w+)\)", cmake, re.MULTILINE),
              *re.findall(r"\$\{CMAKE_SOURCE_DIR\}/([\w.]*\w)", install)} - {".cache"}
    assert "README.md" in needed and needed <= copied(), needed - copied()
    for path in re.findall(r"^include\((\S+)\)", cmake, re.MULTILINE):
        assert {path, path.split("/")[0]} & copied(), path


def test_its_short_names_are_those_of_files_in_it(packaged):
    assert {"/usr/local/bin/learner", "/usr/local/bin/actor"} <= links().keys()
    assert set(links().values()) <= packaged


def test_what_the_manifest_starts_is_in_it(packaged):
    started = set(re.findall(r"/usr/[\w./-]+", MANIFEST))
    assert len(started) == 3 and started <= packaged, started - packaged
    assert "image: metronome:latest" in MANIFEST and "-t metronome ." in TEXT


def test_its_user_and_folder_of_runs_are_those_of_the_manifest():
    (user,) = [words[1] for words in stages()[-1] if words[0] == "USER"]
    number, group = user.split(":")
    assert f"runAsUser: {number}" in MANIFEST and f"fsGroup: {group}" in MANIFEST
    (folder,) = re.findall(rf"install -d -o {number} -g {group} (\S+)", TEXT)
    assert f"mountPath: {folder}" in MANIFEST
