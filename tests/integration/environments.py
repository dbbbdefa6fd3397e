"""Packages from the Python package index for tests: pinned by hash, made once a checkout, under .cache/."""

import subprocess
import sys

import pytest

from harness import ROOT

PIP = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--no-input")
INSTALL = ("install", "--no-deps", "--only-binary", ":all:", "--require-hashes")


def _made_once(name, requirements, *commands):
    """.cache/NAME as `commands` make it of a file of requirements; skips the test if one fails."""
    home = ROOT / ".cache" / name
    stamp = home / ".stamp"
    if stamp.exists() and stamp.read_text() == requirements.read_text():
        return home
    for command in commands:
        made = subprocess.run(command, capture_output=True, text=True, timeout=200)
        if made.returncode != 0:
            pytest.skip(f"no {name} (network?): {made.stderr[-300:]}")
    stamp.write_text(requirements.read_text())
    return home


def python(name, requirements):
    """@return the folder .cache/NAME of a virtual environment with what `requirements` pins."""
    home = ROOT / ".cache" / name
    venv = [sys.executable, "-m", "venv", "--without-pip", "--clear", home]
    return _made_once(name, requirements, venv, [*PIP, "--python", home, *INSTALL, "-r", requirements])


def unpacked(name, requirements, version):
    """@return the folder .cache/NAME of what `requirements` pins for another Python, e.g. "3.10"."""
    home = ROOT / ".cache" / name
    place = ["--upgrade", "--target", home, "--python-version", version]
    return _made_once(name, requirements, [*PIP, *INSTALL, *place, "-r", requirements])
