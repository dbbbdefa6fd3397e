"""The command line of deploy/train, and what of it can be judged before anything is built."""

import argparse
import difflib
import os
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import cores
import folders
import place

NAME = place.called("train")
# Options without a value: the launcher's own, then those of the learner that may stand before TASK.
FLAGS = ("-h", "--help", "--resume", "--new-total")
# Options of the learner that the launcher itself sets, to read what the learner says.
SET_HERE = ("--progress", "--runs-dir", "--log-format")
# A run's name is a folder and a DDS partition, where * ? [ ] would be patterns.
RUN_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
RUN_NAME_RULE = "1 to 64 letters, digits, '.', '_' or '-', a letter or digit first"


def _whole(low, high=None):
    """An argparse type: a whole number of at least `low` (and at most `high`)."""

    def parse(text):
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number") from None
        if value < low or (high is not None and value > high):
            bounds = f"at least {low}" if high is None else f"{low} to {high}"
            raise argparse.ArgumentTypeError(f"{value} is out of range: {bounds}")
        return value

    return parse


def _one_of(names):
    """An argparse type: one of `names`; an error names the near miss and the list."""

    def parse(text):
        if text in names:
            return text
        near = difflib.get_close_matches(text, names, 1)
        hint = f", did you mean '{near[0]}'?" if near else ""
        raise argparse.ArgumentTypeError(f"unknown '{text}'{hint} (one of: {', '.join(names)})")

    return parse


def _engine(text):
    """An argparse type. Of installed programs there is one engine."""
    engine = _one_of(("2.2.2", "3.3.0"))(text)
    if place.ENGINE not in (None, engine):
        raise argparse.ArgumentTypeError(
            f"the installed programs have MuJoCo {place.ENGINE}, not {engine}: that engine has a package of its own"
        )
    return engine


def _run_name(text):
    if not RUN_NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(f"'{text}' cannot name a run: {RUN_NAME_RULE}")
    return text


def _parser():
    checkout, actor = place.CHECKOUT, "build/bin/metronome-actor" if place.CHECKOUT else "metronome-actor"
    parser = argparse.ArgumentParser(
        prog=NAME,
        usage=f"{NAME} [TASK] [OPTION...]",
        add_help=False,
        allow_abbrev=False,
        description="Learns a task on this machine: a learner and actors as child processes"
        f"{', after setting up if needed' * checkout}. Ctrl-C stops all with a checkpoint; --resume goes on.",
        epilog="All other options go to the learner: --heads, --steps, --seed, --config, --set, --network, "
        f"... are listed below{', or, before set-up, in deploy/options.md' * checkout}. Results are kept in runs/NAME/. More "
        f"machines join with: {actor} run --run NAME --network lan",
    )
    parser.add_argument("-h", "--help", action="store_true", help="show this and end")
    parser.add_argument(
        "task",
        metavar="TASK",
        nargs="?",
        help=f"what `{actor} environment` lists, push say (-v2 and -v3 mean the same); "
        "may be left to --config",
    )
    parser.add_argument(
        "--actors",
        type=_whole(0),
        metavar="N",
        default=cores.usable(),
        help="actor processes on this machine; 0: all elsewhere (default: cores that may be used, "
        "%(default)s)",
    )
    parser.add_argument(
        "--envs",
        type=_whole(1),
        metavar="N",
        default=1,
        help="episodes that each actor plays at once (default 1)",
    )
    parser.add_argument(
        "--run",
        type=_run_name,
        metavar="NAME",
        help="the run's name (default: a new one from task, what of --method and --seed is given, and time)",
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on with --run from its newest checkpoint"
    )
    parser.add_argument(
        "--mujoco",
        type=_engine,
        default=place.ENGINE or "2.2.2",
        help="engine (default %(default)s)",
    )
    parser.add_argument(
        "--security",
        type=Path,
        metavar="DIR",
        help="only identities of the run's own authority take part, all is encrypted; DIR is made, "
        "or added to, by deploy/security",
    )
    parser.add_argument(
        "--runs",
        type=Path,
        metavar="DIR",
        default=place.ROOT / "runs" if checkout else Path("runs"),
        help=f"folder of all runs (default: runs/ of {'this checkout' if checkout else 'the current folder'})",
    )
    parser.add_argument(
        "--build",
        type=Path,
        metavar="DIR",
        help=f"use the programs in DIR/bin{' as they are, without set-up' * checkout}",
    )
    return parser


def is_run(folder):
    """Whether the learner finds a run there. A start that was killed in its first moments leaves a
    folder without one."""
    return any(os.path.exists(folder / name) for name in ("config.textproto", "checkpoints"))


def _joined(arguments):
    """Each option and its value as one word, so that a value is not taken for TASK."""
    words = []
    for word in arguments:
        option = words and words[-1].startswith("--") and "=" not in words[-1]
        if option and words[-1] not in FLAGS and not word.startswith("--"):
            words[-1] += f"={word}"
        else:
            words.append(word)
    return words


def given(options, name):
    """@return the value of an option of the learner, the last one; None without."""
    values = [word.partition("=")[2] for word in options.learner if word.startswith(f"{name}=")]
    return values[-1] if values else None


def _fresh_name(options):
    seed = given(options, "--seed")
    parts = (
        options.task or "run",
        given(options, "--method"),
        seed and f"s{seed}",
        time.strftime("%Y%m%d-%H%M%S"),
    )
    base = re.sub(r"[^A-Za-z0-9._-]", "_", "-".join(filter(None, parts))).lstrip("._-")[:58]
    name, count = base, 1
    while os.path.exists(options.runs / name):
        count += 1
        name = f"{base}-{count}"
    return name


def _require_places(parser, options):
    """Makes paths absolute. What is to be a folder can be one, what is to be used is there."""
    finds = {"runs": folders.usable, "security": folders.usable, "build": folders.absolute}
    for name, find in finds.items():
        try:
            path = getattr(options, name)
            setattr(options, name, path and find(path))
        except OSError as error:
            parser.error(f"--{name}: {error}")
    for name in ("learner", *["actor"] * bool(options.actors)):
        program = options.build and options.build / "bin" / f"metronome-{name}"
        if program and not os.path.isfile(program):
            parser.error(f"--build: there is no {program}{'; without --build it is made' * place.CHECKOUT}")


def _require_run_folder(parser, options):
    try:
        options.folder = folders.writable(options.runs / options.run, "--runs")
    except OSError as error:
        parser.error(f"--run {options.run}: {error}")


def warning(options):
    """@return a line about what is asked for and costs more than it gives; None: nothing is."""
    count, limit = cores.usable(), cores.quota()
    sets = r"--(?:threads|set=runtime\.learner_threads)=(\d+)"
    threads = [found[1] for word in options.learner if (found := re.fullmatch(sets, word))]
    asked = {
        "episodes at once (--actors times --envs)": options.actors * options.envs,
        "threads of the learner": int(threads[-1]) if threads else 0,
    }
    much = " and ".join(f"{number} {what}" for what, number in asked.items() if number > count)
    if not much:
        return None
    here = f"{count} core{'s' * (count > 1)}" + (f" (CPU quota {limit:g})" if limit else "")
    return f"{much} on {here}: that is slower than one on each core"


def _show_help(parser, build):
    """The launcher's options, and the learner's where there is one to ask."""
    print(parser.format_help(), end="", flush=True)
    learner = (build or place.BUILD) / "bin" / "metronome-learner"
    if os.path.isfile(learner):
        said = subprocess.run([learner, "run", "--help"], capture_output=True, text=True)
        ours = re.compile(rf" +(-h|--task|--run|--resume|--security|{'|'.join(SET_HERE)})\b")
        lines = said.stdout.partition("Options:\n")[2].splitlines()
        print("\noptions of the learner:", *(line for line in lines if not ours.match(line)), sep="\n")


def _require_for_learner(parser, options):
    """What of the learner's options can be judged before it is built."""
    for word in options.learner:
        name = word.partition("=")[0]
        if not word.startswith("-"):
            parser.error(f"unexpected argument '{word}'")
        if name in SET_HERE:
            parser.error(f"{name} is set by {NAME} itself; leave it out")
    # A run gone on with has read its weights; it only compares the name.
    for name in ("--config", *["--from"] * (not options.resume)):
        path = given(options, name)
        try:
            if path is not None:
                folders.require_file(path)
        except OSError as error:
            parser.error(f"{name}: {error}")


def parse(arguments):
    """Options with .run and .folder filled in; .learner are the words for the learner, each option
    with its value in one word. Exits 2 on what cannot be right, 0 after help."""
    parser = _parser()
    options, learner = parser.parse_known_args(_joined(arguments))
    options.learner = learner
    if options.help:
        _show_help(parser, options.build)
        sys.exit(0)
    options.named = options.run is not None
    if options.task is None and given(options, "--config") is None and not options.resume:
        parser.error(f"which task? For example: {NAME} push")
    _require_for_learner(parser, options)
    if options.resume and not options.named:
        parser.error("--resume needs --run NAME: the run to go on with")
    _require_places(parser, options)
    options.run = options.run or _fresh_name(options)
    _require_run_folder(parser, options)
    if options.resume and not is_run(options.folder):
        there = sorted(path.name for path in options.runs.glob("*/") if is_run(path))
        near = difflib.get_close_matches(options.run, there, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        parser.error(f"there is no run {options.run} in {options.runs} to resume{hint}")
    if not options.resume and is_run(options.folder):
        parser.error(
            f"run {options.run} exists ({options.folder}): go on with it by --resume, "
            "or give another --run NAME"
        )
    return options


def learner_command(options):
    """The learner's command line."""
    command = [
        str(options.build / "bin" / "metronome-learner"),
        "run",
        "--run",
        options.run,
        "--runs",
        str(options.runs),
        "--progress",
        "json",
    ]
    command += [f"--task={options.task}"] if options.task is not None else []
    command += options.learner
    if options.security is not None:
        command += ["--security", str(options.security / "learner")]
    return command + (["--resume"] if options.resume else [])


def actor_command(options, index, started):
    """An actor's command line; `started` is what the learner said when it accepted the run."""
    command = [
        str(options.build / "bin" / "metronome-actor"),
        "run",
        "--run",
        options.run,
        "--envs",
        str(options.envs),
    ]
    for name in ("domain", "transport", "network", "discovery-server"):
        value = started[name.replace("-", "_")]
        if value != "":
            command += [f"--{name}", str(value)]
    # Of a run gone on with the learner knows it.
    security = options.security or (started.get("security") and Path(started["security"]).parent)
    return command + (["--security", str(security / f"actor-{index}")] if security else [])


def resume_command(options):
    """What a person types to go on."""
    words = [word for word in sys.argv[1:] if word != "--resume"]
    words += [] if options.named else ["--run", options.run]
    return shlex.join([folders.typed(place.command("train")), *words, "--resume"])
