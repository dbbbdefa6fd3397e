"""SAC's gradient step alone, against PyTorch on the CPU: the same update, as tests/bench/test_torch.py shows."""

import json
import pathlib
import subprocess
import tempfile

from suite import _stats, peers

NAME = "sac_update"
HELP = "samples a second of SAC's gradient steps, by batch and threads, against PyTorch on the CPU"

OURS, EAGER, COMPILED = "ours", "PyTorch", "PyTorch compiled"
# Batch, threads, gradient steps.
CASES = [(256, 1, 100), (256, 2, 100), (2048, 1, 20), (2048, 2, 20)]


def steps(build, batch, **options):
    """The output of sac_steps: {"samples_per_second": ..., ...}."""
    command = [build / "bin/sac_steps", "--set", f"sac.batch={batch}"]
    for name, value in options.items():
        command += [f"--{name}", str(value)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measure(options, record):
    peers.ensure_installed(options.root)
    with tempfile.TemporaryDirectory() as home:
        for round_number in range(1, options.rounds + 1):
            for batch, threads, count in CASES[:1] if options.quick else CASES:
                folder = pathlib.Path(home) / str(batch)
                if not folder.exists():
                    steps(options.build, batch, steps=5, out=folder)
                ours = steps(options.build, batch, threads=threads, steps=count)
                eager = peers.torch_sac_steps(options.root, folder, threads=threads, steps=count)
                compiled = peers.torch_sac_steps(options.root, folder, threads=threads, steps=count, compile=True)
                case = f"batch {batch}, {threads} thread{'s' if threads > 1 else ''}"
                for quantity, result in ((OURS, ours), (EAGER, eager), (COMPILED, compiled)):
                    record(case=case, quantity=quantity, unit="samples/s", round=round_number,
                           value=result["samples_per_second"])


def table(rows):
    columns = [OURS, EAGER, COMPILED]
    lines = []
    for case, of in _stats.by_case(rows).items():
        rates = [f"{_stats.median(of[name]) / 1e3:.1f}k" for name in columns]
        lines.append([case, *rates, *(f"{_stats.median_ratio(of[OURS], of[name]):.2f}" for name in (EAGER, COMPILED))])
    header = ["gradient step, samples/s", *columns, *(f"ours / {name}" for name in (EAGER, COMPILED))]
    return _stats.markdown(header, lines)
