"""What `shadowgauge publish` and the sources hold on a wire (loopback), row by row: this program as the receiver, and
receivers and cameras that are not ours. Run by benches/peers/camera.sh.

  run.py --binary target/release/shadowgauge [--telegenic PATH] [--short] [ROW…]

Rows: small large measured loss record trigger clock killed silent second changed viva windows dropped (all of them
without names). --short takes a tenth of the times, for a look whether everything runs.
"""
import argparse
import os
import shutil
import sys
import tempfile
import time
import traceback

import fakes
import faults
import stored
import streams


class Bench:
    """What every row needs, and the table."""

    def __init__(self, options, folder):
        self.binary, self.telegenic, self.folder = options.binary, options.telegenic, folder
        root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
        self.small = os.path.join(root, "configs", "small_shaft.toml")
        self.large = os.path.join(root, "configs", "bench_2048.toml")

    def row(self, name, figure):
        print(f"| {name} | {figure} | {os.getloadavg()[0]:.1f} |", flush=True)

    def skip(self, name, why):
        print(f"SKIPPED {name}: {why}", file=sys.stderr, flush=True)

    def missing(self, tool):
        return shutil.which(tool) is None


def rows(bench, short):
    """Every row by its name."""
    s = (lambda seconds: max(2, seconds // 10)) if short else (lambda seconds: seconds)
    return {
        "small": lambda: streams.received(bench, "512² Mono12 at 200/s", bench.small, 200, s(60), "Mono12"),
        "large": lambda: streams.received(bench, "2048² Mono8 at 50/s", bench.large, 50, s(30), "Mono8"),
        "measured": lambda: streams.measured(bench, s(60)),
        "loss": lambda: streams.packet_loss(bench, s(20)),
        "record": lambda: streams.recorded(bench, s(10)),
        "trigger": lambda: streams.trigger(bench, 100 * s(10)),
        "clock": lambda: streams.clock(bench, s(10)),
        "killed": lambda: faults.killed(bench, s(5)),
        "silent": lambda: faults.silent(bench, s(30) + 3),
        "second": lambda: faults.second_client(bench),
        "changed": lambda: faults.changed(bench),
        "viva": lambda: fakes.viva(bench),
        "windows": lambda: stored.blocked(bench, 20_000 if short else 1_000_000),
        "dropped": lambda: stored.dropped(bench, s(10)),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--telegenic")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("names", nargs="*", metavar="ROW")
    options = parser.parse_args()
    print(time.strftime("%Y-%m-%d %H:%M"), f"{os.cpu_count()} cores")
    print("| what | found | load |\n|---|---|---|")
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        all_rows = rows(Bench(options, folder), options.short)
        unknown = set(options.names) - set(all_rows)
        if unknown:
            parser.error(f"no row {sorted(unknown)}; there are {' '.join(all_rows)}")
        for name in options.names or all_rows:
            try:
                all_rows[name]()
            except Exception as error:  # one row that fails leaves the others
                failed += 1
                print(f"FAILED {name}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
                traceback.print_exc()
    sys.exit(1 if failed else 0)


main()
