"""deploy/security: makes and looks after the credentials of a run's participants."""

import argparse
import datetime
import sys
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "launcher"))

import cores  # noqa: E402
import folders  # noqa: E402
import place  # noqa: E402
import roles  # noqa: E402
import terminal  # noqa: E402
from authority import FOLDER, STAGED, Authority, Refused  # noqa: E402

NAME = place.called("security")


def _name(text):
    if not roles.NAME.fullmatch(text) or text == FOLDER:
        raise argparse.ArgumentTypeError(
            f"'{text}' cannot name an identity: 1 to 64 letters, digits, '.', '_' or '-', "
            f"a letter or digit first, and not '{FOLDER}'"
        )
    return text


def _whole(low, high):
    def parse(text):
        if not text.isdecimal() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number in {low}..{high}")
        return int(text)

    return parse


def _parser():
    parser = argparse.ArgumentParser(
        prog=NAME,
        allow_abbrev=False,
        description="Makes what the participants of a secured run need: in DIR a folder each for the "
        "learner, an observer and the actors, to be copied to their machines and named there by "
        "--security. Of a DIR that is there, adds what is missing or has expired: what was stopped goes on.",
        epilog=f"DIR/{FOLDER} can issue identities: keep it where this is run, and nowhere else.",
    )
    parser.add_argument("folder", metavar="DIR", type=Path)
    parser.add_argument("--run", type=_name, metavar="NAME", help="the run; needed for a new DIR")
    parser.add_argument(
        "--domain", type=_whole(0, 232), metavar="N", help="its DDS domain (default 0)"
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--actors",
        type=_whole(0, 100000),
        metavar="N",
        help="actor-0 to actor-N-1 (default: cores here, in a new DIR)",
    )
    which.add_argument(
        "--actor", type=_name, action="append", metavar="NAME", help="an actor; may be repeated"
    )
    parser.add_argument(
        "--days", type=_whole(1, 3650), metavar="D", default=90, help="good for (default 90)"
    )
    parser.add_argument(
        "--renew", action="store_true", help="make all of DIR's identities anew, by new keys"
    )
    parser.add_argument(
        "--revoke",
        type=_name,
        action="append",
        default=[],
        metavar="NAME",
        help="turn an identity away from now on: copy the others' folders again; may be repeated",
    )
    return parser


def _authority(options):
    if not (options.folder / FOLDER).exists():
        if options.run is None:
            raise Refused(f"there are no credentials in {options.folder}: new ones need --run NAME")
        if options.folder.exists() and any(p.name != STAGED for p in options.folder.iterdir()):
            raise Refused(f"{options.folder} holds other things: name a folder that is new")
        made = Authority.make(options.folder, options.run, options.domain or 0)
        made.save()
        return made
    there = Authority.load(options.folder)
    for what in ("run", "domain"):
        asked, its = getattr(options, what), getattr(there, what)
        if asked not in (None, its):
            raise Refused(
                f"{options.folder} is for {what} {its}, not {asked}: name another folder for that"
            )
    return there


def _wanted(options, there):
    actors = options.actor or []
    if options.actors is not None:
        actors = [f"actor-{i}" for i in range(options.actors)]
    elif not there and not actors:
        actors = [f"actor-{i}" for i in range(cores.usable())]
    return list(dict.fromkeys(["learner", "observer", *there, *actors]))


def main():
    terminal.prepare()
    terminal.never_block()  # its work is the files
    options = _parser().parse_args()
    folders.usable(options.folder)
    authority = _authority(options)
    there = authority.names()
    now, days = datetime.datetime.utcnow(), datetime.timedelta(days=options.days)
    if options.revoke:
        authority.revoke(options.revoke)
        print(f"revoked: {', '.join(options.revoke)}; copy every other folder to its machine again")
        there = [name for name in there if name not in options.revoke]
    made = [
        name
        for name in _wanted(options, there)
        if name not in options.revoke
        and (options.renew or not authority.is_good(name, now))
    ]
    for name in made:
        authority.issue(name, days)
    if made:
        print(
            f"{options.folder}: run {authority.run}, domain {authority.domain}, "
            f"good until {now + days:%Y-%m-%d}: {', '.join(made)}"
        )
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Refused, OSError) as error:
        sys.exit(f"{NAME}: {error}")
    except KeyboardInterrupt:
        print(f"{NAME}: stopped; the same command goes on", file=sys.stderr)
        sys.exit(130)
