"""The update alone, against PyTorch on the CPU and the machine's own product rate."""

import json
import subprocess

from suite import _stats, peers

NAME = "learner"
HELP = "samples a second of the whole update, by width and minibatch, against PyTorch on the CPU"

# Width, minibatch, threads.
CASES = [(64, 1000, 2), (128, 1000, 1), (128, 1000, 2), (128, 2500, 2), (256, 1000, 2), (512, 1000, 2)]


def update(build, **options):
    """The output of learner_bench: {"samples_per_second": ..., "gflops": ..., "gemm_gflops": ...}."""
    command = [build / "bin/learner_bench"]
    for name, value in options.items():
        command += [f"--{name}", str(value)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measure(options, record):
    peers.ensure_installed(options.root)
    for round_number in range(1, options.rounds + 1):
        for width, minibatch, threads in CASES[:1] if options.quick else CASES:
            epochs = 10 if width <= 128 else 2
            ours = update(options.build, width=width, minibatch=minibatch, threads=threads, epochs=epochs, repeats=3)
            torch = peers.torch_update(
                options.root, width, minibatch, threads=threads, samples=8000, epochs=2 if width > 128 else 5)
            case = f"2x{width}, minibatch {minibatch}, {threads} thread{'s' if threads > 1 else ''}"

            def note(quantity, unit, value):
                record(case=case, quantity=quantity, unit=unit, round=round_number, value=value)

            note("ours", "samples/s", ours["samples_per_second"])
            note("PyTorch", "samples/s", torch["samples_per_second"])
            note("of GEMM rate", "%", 100 * ours["gflops"] / ours["gemm_gflops"])
            note("GEMM", "GFLOP/s", ours["gemm_gflops"])


def table(rows):
    lines = []
    for case, of in _stats.by_case(rows).items():
        lines.append([
            case, f"{_stats.median(of['ours']) / 1e3:.0f}k", f"{_stats.median(of['PyTorch']) / 1e3:.0f}k",
            f"{_stats.median_ratio(of['ours'], of['PyTorch']):.2f}", f"{_stats.median(of['of GEMM rate']):.0f} %",
            f"{_stats.median(of['GEMM']):.0f}"])
    header = ["update", "ours, samples/s", "PyTorch, samples/s", "ratio", "ours, share of GEMM rate", "GEMM, GFLOP/s"]
    return _stats.markdown(header, lines)
