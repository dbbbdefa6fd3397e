"""The Containerfile: what it copies exists, what it installs is enough, what the manifest starts is in it.

No image is built here. By hand, Buildah 1.28 built both stages (`buildah build`, chroot isolation, on a minimal `bookworm` made by
debootstrap); a learner and an actor, by `buildah run` from that image as user 10001, the learner with a mounted `/runs`, ended a run of
1600 steps with the weights that a build outside gives. Not tried: the official base image, Docker, `podman run`, a read-only root."""

import posixpath
import re
import shlex
import subprocess

from harness import ACTOR, BUILD, LEARNER, ROOT

HOME = "/opt/metronome"
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


def copies(stage):
    """(sources, target, stage that they come from or None) of each COPY."""
    for words in stage:
        if words[0] == "COPY":
            given = [word for word in words[1:] if not word.startswith("--")]
            where = [word.removeprefix("--from=") for word in words if word.startswith("--from=")]
            yield given[:-1], given[-1], where[0] if where else None


def image_files():
    """Paths in the final image that it copies or links by name."""
    paths = set()
    for sources, target, _ in copies(stages()[-1]):
        for source in sources:
            end = posixpath.basename(source) if target.endswith("/") else ""
            paths.add(posixpath.normpath(posixpath.join(HOME, target, end)))
    return paths


def links():
    """(target, link) of every ln -s of the final image."""
    for words in stages()[-1]:
        command = " ".join(words[1:]) if words[0] == "RUN" else ""
        for given in re.findall(r"ln -s ([^&]+)", command):
            *targets, link = given.split()
            for target in targets:
                yield target, posixpath.join(link, posixpath.basename(target)) if link.endswith("/") else link


def test_it_copies_what_the_checkout_has_and_set_up_makes():
    for stage in stages():
        for sources, _, where in copies(stage):
            for source in sources:
                made = source.removeprefix(f"{HOME}/build/")
                if where is None:
                    assert (ROOT / source).exists(), source
                elif made != source:
                    assert (BUILD / made).exists(), source
                else:
                    assert (ROOT / source.removeprefix(f"{HOME}/")).exists(), source


def test_the_build_stage_has_all_that_set_up_compiles():
    copied = {source for sources, _, _ in copies(stages()[0]) for source in sources}
    folders = re.findall(r"^add_subdirectory\((\w+)\)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)
    assert {*folders, "CMakeLists.txt", "CMakePresets.json", "deploy/setup"} <= copied
    read = set(re.findall(r"deploy/[\w.-]+\.(?:txt|sh)", (ROOT / "deploy" / "setup").read_text()))
    included = set(re.findall(r"^include\((\S+)\)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE))
    for path in read | included:
        assert {path, path.split("/")[0]} & copied, path


def test_its_short_names_are_those_of_files_in_it():
    names = {}
    for target, link in links():
        assert target in image_files(), target
        names[posixpath.basename(link)] = target
    assert {"learner", "actor", "metronome-learner", "metronome-actor"} <= names.keys()


def test_what_the_manifest_starts_is_in_it():
    started = set(re.findall(rf"{HOME}/[\w./-]+", MANIFEST)) - {HOME}
    assert started, "the manifest names no file of the image"
    assert started <= image_files()
    assert "image: metronome:latest" in MANIFEST and "-t metronome ." in TEXT


def test_its_user_and_folder_of_runs_are_those_of_the_manifest():
    (user,) = [words[1] for words in stages()[-1] if words[0] == "USER"]
    number, group = user.split(":")
    assert f"runAsUser: {number}" in MANIFEST and f"fsGroup: {group}" in MANIFEST
    (folder,) = re.findall(rf"install -d -o {number} -g {group} (\S+)", TEXT)
    assert f"mountPath: {folder}" in MANIFEST


def test_the_packages_it_installs_hold_every_library_of_the_programs():
    linked = subprocess.run(["ldd", LEARNER, ACTOR], capture_output=True, text=True, check=True).stdout
    libraries = sorted(set(re.findall(r"=> (/\S+)", linked)))
    final = " ".join(" ".join(words) for words in stages()[-1])
    installed = set(re.findall(r"[a-z][\w.+-]+", final.split("--no-install-recommends")[1].split("&&")[0]))
    # All that comes with a package: dependencies are theirs to name.
    with_dependencies = subprocess.run(
        ["apt-cache", "depends", "--recurse", "--installed", "--no-recommends", "--no-suggests",
         "--no-conflicts", "--no-breaks", "--no-replaces", "--no-enhances", *sorted(installed)],
        capture_output=True, text=True, check=True).stdout
    there = set(re.findall(r"^([a-z0-9][\w.+-]+)", with_dependencies, re.MULTILINE))
    owners = owners_of(libraries)
    assert len(owners) > 10 and owners <= there, owners - there


def owners_of(libraries):
    """@return the Debian packages of the files; /lib is /usr/lib, and dpkg knows only one of them."""
    real = subprocess.run(["readlink", "-f", *libraries], capture_output=True, text=True, check=True).stdout.split()
    paths = [name for path in real for name in (path, path.removeprefix("/usr"))]
    found = subprocess.run(["dpkg", "-S", *paths], capture_output=True, text=True, check=False).stdout
    known = {path: line.split(":")[0] for line in found.splitlines() for path in [line.split(" ")[-1]]}
    for path in real:
        assert path in known or path.removeprefix("/usr") in known, f"no package has {path}"
    return set(known.values())
