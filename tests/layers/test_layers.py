"""The tables of folders in the READMEs are true: of every #include, CMake target, namespace, of what lies in a folder."""

import graphlib
import re
import subprocess
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("idl", "common", "learner", "actor")
MOST_FILES = 30  # sources and headers in one folder
ROW = re.compile(r"\| `(?P<folder>[a-z_/]+)/` \| `(?P<target>[\w-]+)` \| (?P<includes>[^|]*) \|")


def table():
    """{folder: (CMake target, folders that it may include)}, of all READMEs."""
    rows = {}
    for part in PARTS:
        for row in ROW.finditer((ROOT / part / "README.md").read_text()):
            rows[row["folder"]] = (row["target"], {name[:-1] for name in re.findall(r"`([a-z_/]+/)`", row["includes"])})
    return rows


def sources():
    names = subprocess.run(["git", "ls-files", "*.h", "*.cc"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [Path(name) for name in names.stdout.split() if name.split("/")[0] in PARTS]


def arrows(files, root=ROOT):
    """{folder: {folder that it includes: [where]}}, of our own headers, generated ones too."""
    found = defaultdict(lambda: defaultdict(list))
    for path in files:
        text = (root / path).read_text()
        for match in re.finditer(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">]', text, re.MULTILINE):
            target = str(Path(match[1]).parent)
            if target.split("/")[0] in (*PARTS, "tests") and target != str(path.parent):
                line = text.count("\n", 0, match.start()) + 1
                found[str(path.parent)][target].append(f"{path}:{line}: {match[1]}")
    return found


def forbidden(found, rows):
    return [place for folder, targets in found.items() for target, places in targets.items()
            if target not in rows.get(folder, ("", set()))[1] for place in places]


def test_every_include_follows_an_arrow_of_the_tables():
    assert not forbidden(arrows(sources()), table())


def test_an_include_against_the_arrows_is_found(tmp_path):
    against = Path("common/policy/policy.cc")
    (tmp_path / against).parent.mkdir(parents=True)
    (tmp_path / against).write_text('#include "common/policy/policy.h"\n\n#include "learner/ppo/trainer.h"\n')
    assert forbidden(arrows([against], tmp_path), table()) == ["common/policy/policy.cc:3: learner/ppo/trainer.h"]


def test_the_arrows_have_no_circle():
    tuple(graphlib.TopologicalSorter({folder: may for folder, (_, may) in table().items()}).static_order())


def test_every_arrow_is_used():
    found = arrows(sources())
    assert {folder: set(found[folder]) for folder in table()} == {folder: may for folder, (_, may) in table().items()}


def test_the_tables_have_every_folder_and_none_is_too_large():
    files = defaultdict(int)
    for path in sources():
        files[str(path.parent)] += 1
    generated = {"idl", "common/schema"}
    assert set(table()) == set(files) | generated
    assert max(files.values()) <= MOST_FILES, files


def namespace_of(folder):
    """A folder's namespace is its path below the part; what crosses the wire is everybody's vocabulary."""
    part, *below = folder.split("/")
    return "metronome" if folder == "common/messages" else "::".join(["metronome", *(below or [part])])


def misplaced(files, root=ROOT):
    return [f"{path}: {name}" for path in files
            for name in re.findall(r"^namespace (metronome[\w:]*) \{", (root / path).read_text(), re.MULTILINE)
            if name != namespace_of(str(path.parent))]


def test_a_folder_is_one_namespace():
    assert not misplaced(sources())


def test_a_file_in_the_namespace_of_another_folder_is_found(tmp_path):
    path = Path("learner/collect/assignments/roster.cc")
    (tmp_path / path).parent.mkdir(parents=True)
    (tmp_path / path).write_text("namespace metronome::collect {\n}\n")
    assert misplaced([path], tmp_path) == [f"{path}: metronome::collect"]


def hidden_mutexes(files, root=ROOT):
    """Of those that Clang does not check."""
    return [f"{path}: {name}" for path in files if path != Path("common/process/mutex.h")
            for name in re.findall(r"std::\w*mutex\b|std::\w+_lock\b|std::lock_guard\b", (root / path).read_text())]


def test_every_mutex_is_one_that_clang_checks():
    assert not hidden_mutexes(sources())


def test_a_mutex_that_clang_does_not_check_is_found(tmp_path):
    (tmp_path / "a.cc").write_text("static std::mutex mutex;\nconst std::lock_guard lock(mutex);\n")
    assert hidden_mutexes([Path("a.cc")], tmp_path) == ["a.cc: std::mutex", "a.cc: std::lock_guard"]


def cmake_of(folder):
    """CMake's commands without comments."""
    return re.sub(r"#.*", "", (ROOT / folder / "CMakeLists.txt").read_text())


def targets_of(folder):
    """{target: [what it is linked with]}."""
    text = cmake_of(folder)
    linked = {target: [] for target in re.findall(r"add_(?:library|executable)\(([\w-]+)", text)}
    for target, words in re.findall(r"target_link_libraries\(([\w-]+)([^)]*)\)", text):
        linked[target] += words.split()
    return linked


@pytest.mark.parametrize("folder", sorted(table()))
def test_a_folder_is_one_target_that_is_linked_with_what_it_includes(folder):
    target, may = table()[folder]
    targets = targets_of(folder)
    assert target in targets
    ours = {row[0] for row in table().values()}
    linked = {word for words in targets.values() for word in words if word in ours} - {target}
    assert linked == {table()[other][0] for other in may}
