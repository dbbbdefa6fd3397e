"""Shared by the wire's measurements: processes in a domain and a folder of their own."""

import contextlib
import csv
import json
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "integration"))
import harness  # noqa: E402  (domains that no other test of this machine uses; no child outlives us)

PATIENCE = 300.0  # seconds: reached only if something is broken


@contextlib.contextmanager
def stage(options, name):
    """A harness.Stage whose processes end with it, and a folder that goes with it."""
    with tempfile.TemporaryDirectory(prefix=f"metronome-{name}-") as folder:
        found = harness.Stage(name, pathlib.Path(folder))
        found.folder, found.bin = pathlib.Path(folder), options.build / "bin"
        try:
            yield found
        finally:
            found.close()


def config_file(on_stage, *settings):
    """A resolved configuration, as `metronome-learner run` with these options would use."""
    path = on_stage.folder / "config.textproto"
    command = on_stage.start(on_stage.bin / "metronome-learner", "config", *settings)
    assert command.wait(PATIENCE) == 0, command
    path.write_text("".join(command.output))
    return path


def swarm(on_stage, command, config, transport, *options):
    """A process of the simulated actors' program."""
    common = ["--config", config, "--domain", on_stage.domain, "--transport", transport]
    return on_stage.start(on_stage.bin / "swarm", command, *common, *options)


def result(process):
    """The output of a swarm command, once it has ended well."""
    assert process.wait(PATIENCE) == 0, process
    return json.loads(process.output[-1])


def learner(on_stage, transport, *settings):
    """A real learner of the run `swarm`."""
    where = ["--run", "swarm", "--runs", on_stage.runs, "--domain", on_stage.domain]
    return on_stage.start(
        on_stage.bin / "metronome-learner", "run", *where,
        "--transport", transport, "--progress", "json", *settings,
    )


def progress(on_stage):
    """The rows of the run's progress.csv, numbers as float."""
    with open(on_stage.runs / "swarm" / "progress.csv", newline="") as file:
        return [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(file)]


def megabytes(process, field):
    """A field of a living process's /proc/PID/status, e.g. VmRSS; None once it is gone."""
    try:
        status = pathlib.Path(f"/proc/{process.child.pid}/status").read_text()
    except OSError:
        return None
    for line in status.splitlines():
        if line.startswith(field + ":"):
            return float(line.split()[1]) / 1024
    return None
