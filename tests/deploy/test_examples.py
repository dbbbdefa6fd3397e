"""The commands that pages and --help print as examples.

Run, each by itself, as printed, in a folder that looks like a built checkout: those of deploy/train, deploy/security, metronome-learner
and metronome-actor in a page's blocks of code, and in the tables of README.md. What is changed: runs are small (but box-close's, say, is
still box-close) and on this machine's loopback, in a DDS domain of their own; evaluations have one episode, videos two frames. An actor
and `status` get a learner to talk to, a learner gets an actor.

Judged without being run: all other programs of this repository (tests/run, say, would run this test), commands within lines, and examples
in --help. Their program, subcommand, options and the files of the repository that they name must exist. Of other people's programs (git,
podman, sbatch, ...) only the files and our own programs within their command line are judged. A name of a test (`-R`, `-k`) must find one.
"""

import itertools
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

import options_page
from harness import ACTOR, BUILD, LEARNER, ROOT, small

OTHERS = {"git", "cd", "cmake", "ctest", "tensorboard", "prometheus", "scp", "podman", "install", "systemctl", "sbatch", "kubectl",
          "apt-get", "jq", "fast-discovery-server", "cyclonedds", "export", "/usr/bin/python3"}
OURS = re.compile(r"(?:build(?:-3\.3\.0)?/bin/)?metronome-(?:actor|learner)|(?:deploy|tests)/[a-z_/]+(?:\.sbatch)?")
SUBCOMMANDS = ("run", "inspect", "export", "config", "status", "evaluate", "render", "trace", "placements", "tasks", "environment")
# Options of learners that `metronome-learner config` does not have, and the launcher's own; those without a value.
NOT_OF_CONFIG = {"--run", "--runs", "--runs-dir", "--progress", "--log-level", "--log-format", "--actors", "--envs", "--mujoco", "--build"}
FLAGS = {"--resume", "--new-total"}
PLACEHOLDERS = {"TASK", "OPTION...", "...", "K", "X", "F", "--resume"}
PAGES = [name for name in subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True).stdout.split()]
HELPS = [("deploy/train",), ("deploy/setup",), ("deploy/learner",), ("deploy/security",), ("deploy/experiment",), ("deploy/exchange",),
         ("tests/run",), ("tests/chaos/run",), ("tests/fuzz/run",), ("tests/threads/run",), ("tests/bench/run",), ("tests/fresh/run",),
         *((program, *words) for program in ("metronome-learner", "metronome-actor") for words in ((), ("run",))),
         *(("metronome-learner", word) for word in ("inspect", "config", "status")),
         *(("metronome-actor", word) for word in ("evaluate", "render", "trace", "placements", "tasks", "environment"))]


def commands_of(line):
    """The commands of a line as lists of words, without comments and settings of the environment."""
    words = shlex.split(line.replace("$(nproc)", "2").replace("<", "").replace(">", ""), comments=True)
    found = [[]]
    for word in words:
        found[-1].append(word.removesuffix(";"))
        if word.endswith(";"):
            found.append([])
    found = [[word for at, word in enumerate(one) if at or not re.match(r"[A-Z_]+=", word)] for one in found]
    return [one for one in found if one]


def block_lines(page):
    """Lines of a page's blocks of commands: fenced as `sh`, or indented and beginning with a program of ours."""
    text = (ROOT / page).read_text()
    for fence in re.finditer(r"^( *)```(\w*)\n(.*?)^ *```$", text, re.DOTALL | re.MULTILINE):
        if fence[2] == "sh":
            yield from filter(None, map(str.strip, fence[3].replace("\\\n", " ").splitlines()))
    text = re.sub(r"^( *)```.*?^ *```$", "", text, flags=re.DOTALL | re.MULTILINE)
    yield from re.findall(rf"^ {{4}}((?:{OURS.pattern}) .*)$", text, re.MULTILINE)


def inline_lines(page):
    """Commands of ours within lines, at least two words."""
    text = re.sub(r"^( *)```.*?^ *```$", "", (ROOT / page).read_text(), flags=re.DOTALL | re.MULTILINE)
    yield from re.findall(rf"`((?:{OURS.pattern}) [^`\n]+)`", text)


def ours(words):
    """The part of a command that a program of this repository gets: all of it, or what podman and sbatch hand on."""
    if words[0] == "podman" and "metronome" in words[1:]:
        rest = words[words.index("metronome", 1) + 1:]
        return [{"learner": "deploy/learner", "actor": "metronome-actor"}[rest[0]], *rest[1:]] if rest and rest[0] != "." else []
    if words[0] == "sbatch":
        at = words.index("deploy/slurm/metronome.sbatch")
        return ["deploy/learner", "runs", *words[at + 1:]]
    return words if OURS.fullmatch(words[0]) else []


def program_of(word):
    """@return the file."""
    name = word.rpartition("/")[2]
    return BUILD / "bin" / name if name.startswith("metronome-") else ROOT / word


def options_known(words):
    """All options of the program, of its subcommand where it has some."""
    program = program_of(words[0])
    assert os.access(program, os.X_OK), f"there is no program {words[0]}"
    if words[0] == "deploy/learner":
        return options_known(["metronome-learner", "run"])
    command = [str(program)]
    if program.name.startswith("metronome-") and len(words) > 1 and not words[1].startswith("-"):
        assert words[1] in SUBCOMMANDS, f"{words[0]} has no {words[1]}"
        command.append(words[1])
    if words[0] == "deploy/train":
        command += ["--build", str(BUILD)]
    return set(re.findall(r"(?<![\w-])--?[a-zA-Z][a-z-]*", options_page.help_of(*command)))


def judge(words):
    """Fails if the options of a command of ours, or files that any command names, do not exist."""
    for word in words:
        path = word.partition("=")[2] or word
        if re.fullmatch(r"(?:deploy|tests|results|common|actor)/[\w./-]+\.\w+", path):
            assert (ROOT / path).exists(), f"{shlex.join(words)}: there is no {path}"
    mine = ours(words)
    if not mine:
        assert words[0] in OTHERS or OURS.fullmatch(words[0]), f"nobody knows {words[0]}: {shlex.join(words)}"
        return
    known = options_known(mine)
    if mine[0] in ("tests/run", "tests/threads/run"):
        known |= {"-R"}  # ctest's
    before_dashes = mine[:mine.index("--")] if "--" in mine else mine
    for word in before_dashes[1:]:
        if re.match(r"--?[a-z]", word, re.IGNORECASE):
            assert word.partition("=")[0] in known, f"{shlex.join(words)}: there is no option {word}"
    if mine[0] in ("deploy/train", "deploy/learner") or mine[1:2] == ["run"] and "learner" in mine[0]:
        judge_configuration(mine)


def judge_configuration(words):
    """Lets the learner judge the values of a run's options, where they are values."""
    if any(word in PLACEHOLDERS for word in words):
        return
    rest = words[{"deploy/train": 1, "deploy/learner": 3}.get(words[0], 2):]
    if words[0] == "deploy/train" and not rest[0].startswith("-"):
        rest.insert(0, "--task")
    command = [LEARNER, "config"]
    for before, word in itertools.pairwise(["", *rest]):
        if word not in (*NOT_OF_CONFIG, *FLAGS) and before not in NOT_OF_CONFIG:
            command.append(word)
    if not {"--task", "--config"} & set(command):  # the program's name, with nothing to judge or with one option
        command += ["--task", "push"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert said.returncode == 0, f"{shlex.join(words)}: {said.stderr}"


@pytest.mark.parametrize("page", PAGES)
def test_every_command_of_a_page_can_be_given(page):
    for line in (*block_lines(page), *inline_lines(page)):
        for words in commands_of(line):
            judge(words)


@pytest.mark.parametrize("command", HELPS, ids=" ".join)
def test_every_command_in_a_help_can_be_given(command):
    text = options_page.help_of(program_of(command[0]), *command[1:])
    for example in re.findall(rf"(?:{OURS.pattern})(?: [\w./=*$()-]+)*", text):
        words = example.split()
        if not os.access(program_of(words[0]), os.X_OK) or program_of(words[0]).is_dir():
            continue  # the name of a folder, or of a file that is no program
        known = options_known(words[:2] if words[1:2] and words[1] in SUBCOMMANDS else words[:1])
        for word in words[1:]:
            if word.startswith("--") and len(word) > 2:
                assert word.partition("=")[0] in known, f"{example}: there is no option {word}"


def test_every_name_of_a_test_finds_one():
    lines = [line for page in PAGES for line in (*block_lines(page), *inline_lines(page))]
    lines += re.findall(r"tests/run --only .*", options_page.help_of(ROOT / "tests" / "run"))
    named = 0
    for words in (words for line in lines for words in commands_of(line)):
        if "-R" in words and "NAME" not in words:
            found = subprocess.run(["ctest", "--test-dir", BUILD, "-N", *words[words.index("-R"):]], capture_output=True, text=True)
            assert not re.search(r"Total Tests: 0$", found.stdout, re.MULTILINE), f"{shlex.join(words)} finds no test"
            named += 1
        if "-k" in words and "WORDS" not in words:
            at = words.index("pytest")
            found = subprocess.run(["/usr/bin/python3", "-I", "-B", "-m", *words[at:], "--collect-only", "-q"], cwd=ROOT,
                                   capture_output=True, text=True)
            assert found.returncode == 0, f"{shlex.join(words)} finds no test: {found.stdout}"
            named += 1
    assert named >= 2


def kind_of(words):
    """The program, with its subcommand."""
    name = words[0].rpartition("/")[2]
    return " ".join((name, *words[1:2])) if name.startswith("metronome-") else words[0]


def runnable():
    """(page, line) of each command that is run, once a page."""
    for page in PAGES:
        lines = [*block_lines(page), *(inline_lines(page) if page == "README.md" else ())]
        every = [words for line in lines for words in commands_of(line)]
        yield from dict.fromkeys((page, shlex.join(words)) for words in every if kind_of(words) in RUNNERS and len(words) > 1)


TINY = small(400)  # two updates
TINY_SETTINGS = TINY[2:]  # without the task
# In place of what a page says: one machine, small runs.
INSTEAD = {"--network": "loopback", "--metrics": "0", "--episodes": "1"}
WITHOUT = ("--discovery-server", "--steps", "--seed")


class Checkout:
    """A folder that looks like a built checkout; runs, pictures and identities are its own."""

    def __init__(self, stage, folder):
        self.stage, self.folder = stage, folder
        for name in ("deploy", "results"):
            (folder / name).symlink_to(ROOT / name)
        (folder / "build").symlink_to(BUILD)

    def start(self, *words):
        return self.stage.start("env", "-C", self.folder, *words)

    def check(self, *words):
        process = self.start(*words)
        assert process.wait() == 0, process
        return process

    def learner(self, run, identity=None):
        return self.stage.learner(run, *self.security(identity, "learner"), small=TINY)

    def actor(self, run, identity=None):
        return self.stage.actor(run, *self.security(identity, "actor-3"))

    def security(self, identity, whose):
        return ("--security", self.folder / "DIR" / whose) if identity else ()

    def train(self, run):
        """runs/RUN as a run that has ended leaves it."""
        learner = self.stage.learner(run, small=TINY, runs=self.folder / "runs")
        ended(learner, self.stage.actor(run))

    def identities(self):
        """DIR, as encryption.md makes it, and an actor's copied."""
        self.check("deploy/security", "DIR", "--run", "NAME", "--actors", "4", "--domain", self.stage.domain)
        (self.folder / "actor-3").symlink_to(self.folder / "DIR" / "actor-3")


def ended(*processes):
    for process in processes:
        assert process.wait() == 0, process


def value(words, option):
    return words[words.index(option) + 1] if option in words else None


def settings_of(task):
    """TINY_SETTINGS; of several tasks with an episode of each."""
    described = subprocess.run([ACTOR, "environment", *task], capture_output=True, text=True).stdout
    tasks = described.count("\ntasks: ")
    return [f"collection.episodes_per_update={tasks}" if tasks and "episodes_per_update" in word else word
            for word in TINY_SETTINGS]


def run_train(checkout, words):
    words += ["--build", "build", "--runs", "runs"]
    if "--resume" in words:
        checkout.train(value(words, "--run"))
    else:
        words += [*settings_of(words[1:2]), "--domain", checkout.stage.domain, *(() if "--actors" in words else ("--actors", "1"))]
    said = checkout.check(*words).text
    for line in re.findall(rf"(?:{OURS.pattern}) .*", said):  # what to type next
        judge(shlex.split(line))


def run_security(checkout, words):
    if "--run" not in words:  # it changes a DIR that is there
        checkout.identities()
    checkout.check(*words)
    assert (checkout.folder / "DIR" / "learner" / "key.pem").exists()


def run_learner(checkout, words):
    learner = checkout.start(*words, *TINY_SETTINGS, "--domain", checkout.stage.domain)
    ended(checkout.actor(value(words, "--run"), "--security" in words), learner)


def run_actor(checkout, words):
    learner = checkout.learner(value(words, "--run"), "--security" in words)
    ended(checkout.start(*words, "--domain", checkout.stage.domain), learner)


def run_status(checkout, words):
    learner = checkout.learner(words[2], "--security" in words)
    status = checkout.start(*words, "--domain", checkout.stage.domain)
    status.expect_text("task push")  # it has heard the learner, which waits for an actor
    ended(checkout.actor(words[2], "--security" in words), status, learner)


def run_policy(checkout, words):
    made = [path for path in words if path.startswith("runs/")]
    for path in made:
        checkout.train(Path(path).parts[1])
    shutil.copy(ROOT / "results" / "policies" / "push.ckpt", checkout.folder / "F")
    if words[1] == "render":
        words += ["--size", "160x160", *(["--every", "250"] if value(words, "--out").endswith(".mp4") else [])]
    checkout.check(*words)
    for option in ("--out", "--csv"):
        if option in words:
            assert (checkout.folder / value(words, option)).stat().st_size > 0


def run_as_it_is(checkout, words):
    checkout.check(*words)


RUNNERS = {
    "deploy/train": run_train,
    "deploy/security": run_security,
    "metronome-learner run": run_learner,
    "metronome-learner status": run_status,
    "metronome-learner inspect": run_policy,
    "metronome-learner config": run_as_it_is,
    "metronome-actor run": run_actor,
    "metronome-actor evaluate": run_policy,
    "metronome-actor render": run_policy,
}


@pytest.mark.parametrize("page, line", [pytest.param(page, line, id=f"{page}: {line}") for page, line in runnable()])
def test_a_command_of_a_page_runs(stage, tmp_path, page, line):
    checkout = Checkout(stage, tmp_path)
    words = [INSTEAD.get(before, word) for before, word in itertools.pairwise(["", *shlex.split(line)])]
    for option in WITHOUT:
        if option in words:
            del words[words.index(option):words.index(option) + 2]
    if words[0].startswith("metronome-"):
        words[0] = f"build/bin/{words[0]}"
    if "--security" in words and words[0] != "deploy/train":
        checkout.identities()
    RUNNERS[kind_of(words)](checkout, words)
