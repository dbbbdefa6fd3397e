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


class _Once(argparse.Action):
    """Keeps a value, as argparse does by default, which of an option that is given twice drops the first without a
    word."""

    given = False

    def __call__(self, parser, options, value, option_string=None):
        if self.given:
            before = getattr(options, self.dest)
            parser.error(f"{option_string} is given twice, and it has one value: {before} or {value}?")
        self.given = option_string is not None
        setattr(options, self.dest, value)


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
        f"... are listed below{', or, before set-up, in deploy/options.md' * checkout}. Results are kept in runs/NAME/. A run that "
        f"is started with --network lan takes actors of more machines: {actor} run --run NAME --network lan",
    )
    parser.register("action", None, _Once)
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
        help="actor processes on this machine; 0: all elsewhere (default: one for each core that may be used, here "
        f"{cores.usable()}, as far as an update has episodes for them)",
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
        help="the run's name (default: a new one from task or the first --config, what of --method and --seed is given, and time)",
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
        f"or added to, by {place.called('security')}",
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
    """@return True if the learner finds a run there. A start that was killed in its first moments leaves a
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


def all_given(options, name):
    """@return each value that an option of the learner has, in order."""
    return [word.partition("=")[2] for word in options.learner if word.startswith(f"{name}=")]


def given(options, name):
    """@return the value of an option of the learner that has one; None without."""
    return next(iter(all_given(options, name)), None)


def _fresh_name(options):
    seed, config = given(options, "--seed"), given(options, "--config")
    parts = (
        options.task or (Path(config).stem if config else "run"),
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
        ours = re.compile(rf" +(-h|--task|--runs?|--resume|--security|{'|'.join(SET_HERE)})\b")
        lines = said.stdout.partition("Options:\n")[2].splitlines()
        print("\noptions of the learner:", *(line for line in lines if not ours.match(line)), sep="\n")


def _require_for_learner(parser, options):
    """Judges the learner's options as far as that is possible before it is built."""
    for word in options.learner:
        name = word.partition("=")[0]
        if not word.startswith("-"):
            parser.error(f"unexpected argument '{word}'")
        if name in SET_HERE:
            instead = "give --runs" if name == "--runs-dir" else "leave it out"
            parser.error(f"{name} is set by {NAME} itself; {instead}")
    # A run gone on with has read its weights; it only compares the name.
    for name in ("--config", *["--from"] * (not options.resume)):
        for path in all_given(options, name):
            try:
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
    options.counted = options.actors is not None
    if not options.counted:
        options.actors = cores.usable()
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


# How to find a run: options of the learner, of actors and of `status`, and their defaults.
WAYS = {"domain": 0, "transport": "udp", "network": "loopback", "discovery-server": ""}


def _joining(options, started, identity):
    """The options by which a process of this machine joins the run, beside its name; `started` is what the learner
    said when it accepted the run, `identity` the process's, where the run is secured."""
    words = []
    for name, default in WAYS.items():
        value = started[name.replace("-", "_")]
        if value != default:
            words += [f"--{name}", str(value)]
    # Of a run gone on with the learner knows it.
    security = options.security or (started.get("security") and Path(started["security"]).parent)
    return words + (["--security", str(security / identity)] if security else [])


def actor_command(options, index, started):
    """An actor's command line. It computes by the learner's instructions, where those are chosen."""
    isa = given(options, "--isa")
    return [
        str(options.build / "bin" / "metronome-actor"), "run", "--envs", str(options.envs), "--run", options.run,
        *([] if isa is None else ["--isa", isa]), *_joining(options, started, f"actor-{index}"),
    ]


def _typed(options, program, *words):
    return shlex.join([folders.typed(options.build / "bin" / program), *words])


def join_command(options, started):
    """The command that starts an actor on this machine."""
    return _typed(options, "metronome-actor", "run", "--run", options.run, *_joining(options, started, "actor-0"))


def watch_command(options, started):
    """The command that shows the run from this machine."""
    return _typed(options, "metronome-learner", "status", options.run, *_joining(options, started, "observer"))


def resume_command(options):
    """The command that goes on with the run."""
    words = [word for word in sys.argv[1:] if word != "--resume"]
    words += [] if options.named else ["--run", options.run]
    return shlex.join([folders.typed(place.command("train")), *words, "--resume"])


def wide_command(options):
    """The command for a new run that has episodes for all of options.actors."""
    train, wide = folders.typed(place.command("train")), folders.shown(place.data("wide.textproto"))
    ours = ("--resume", "--run=", f"--config={wide}", "--set=collection.episodes_per_update=")
    words = [word for word in _joined(sys.argv[1:]) if not word.startswith(ours)]
    episodes = 2 * options.actors * options.envs
    return shlex.join([train, *words, "--config", wide, "--set", f"collection.episodes_per_update={episodes}"])
