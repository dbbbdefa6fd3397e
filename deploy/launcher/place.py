"""Where this launcher lies: in a checkout, which sets up and builds its programs, or in an installation."""

from pathlib import Path

_AROUND = Path(__file__).resolve().parents[1]  # deploy/ of a checkout, share/metronome/ of an installation
_ENGINE = _AROUND / "engine"  # as deploy/CMakeLists.txt writes it

CHECKOUT = not _ENGINE.exists()
# MuJoCo of the installed programs; None in a checkout.
ENGINE = None if CHECKOUT else _ENGINE.read_text(encoding="utf-8").strip()
# The checkout, or the installation.
ROOT = _AROUND.parent if CHECKOUT else _AROUND.parents[1]
# The folder whose bin/ holds programs of the default engine.
BUILD = ROOT / "build" if CHECKOUT else ROOT


def command(name):
    """@return the path of the command deploy/NAME of a checkout, bin/metronome-NAME of an installation."""
    return ROOT / "deploy" / name if CHECKOUT else ROOT / "bin" / f"metronome-{name}"


def called(name):
    """@return what a person calls that command."""
    return f"deploy/{name}" if CHECKOUT else f"metronome-{name}"


def data(name):
    """@return the path of a file that lies beside the launcher's folder."""
    return _AROUND / name
