#!/usr/bin/env python3
"""Which unit test holds the case of a threshold of the gauge: each is put out of action, either way.

    scripts/limits_held.py [--only PATTERN] [--factor F] [--seconds S] [--both] [--csv FILE]

Beside `shadowgauge study limits`, which prints what a threshold changes in rendered scenes when it is halved and
doubled: one that changes nothing there is deleted unless a test holds its case, that is, fails when the threshold is
divided or multiplied by so much (F, a million unless given) that what it decides is always decided alike. Each test
runs alone once, noting the groups of thresholds that it reads; then each variant runs those tests, first those that
read the fewest groups, until one fails, for at most S seconds (20) of a variant. A threshold is held by a test that
fails either way: the second way is tried where the first fails none (`--both`: always). Prints a row a variant:
threshold, way, value, the test that fails (`-` where none does). A `--csv` that is there already is gone on with.
"""
import argparse
import csv
import json
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

BATCH_S = 3.0


def test_binary():
    """The unit tests, built as `cargo test --release` builds them."""
    command = ["cargo", "test", "--release", "--locked", "--lib", "--no-run", "--message-format=json"]
    out = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    built = [json.loads(line) for line in out.splitlines() if line.startswith("{")]
    return [b["executable"] for b in built if b.get("executable")][-1]


def run_noting(binary, name):
    """Whether a test fails as it is, and the groups of thresholds that it reads."""
    done = subprocess.run([binary, "--exact", "--nocapture", name], env={**os.environ, "SHADOWGAUGE_LIMITS_READ": "1"},
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    return done.returncode != 0, set(re.findall(r"^limits read: (\S+)$", done.stderr, re.M))


def run(binary, tests, variant, timeout=600):
    """Runs tests in one process; gives the names of those that fail (all, where it dies; none, where it hangs: a
    threshold that only makes a test slow is not held by it)."""
    env = {**os.environ, "SHADOWGAUGE_LIMIT": variant}
    try:
        done = subprocess.run([binary, "--exact", "--test-threads=1", *tests], env=env, timeout=timeout,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    except subprocess.TimeoutExpired:
        return []
    if done.returncode == 0:
        return []
    return re.findall(r"^test (\S+)(?: - should panic)? \.\.\. FAILED", done.stdout, re.M) or tests


def survey(binary):
    """Every test with its seconds and the groups that it reads."""
    listed = subprocess.run([binary, "--list", "--format", "terse"], check=True, stdout=subprocess.PIPE, text=True).stdout
    ignored = subprocess.run([binary, "--list", "--format", "terse", "--ignored"], check=True, stdout=subprocess.PIPE, text=True).stdout
    names = [line[:-6] for line in listed.splitlines() if line.endswith(": test")]
    left_out = {line[:-6] for line in ignored.splitlines()}
    tests = []
    for name in names:
        if name in left_out:
            continue
        start = time.monotonic()
        failed, groups = run_noting(binary, name)
        seconds = time.monotonic() - start
        if failed:
            print(f"left out, fails as it is: {name}", file=sys.stderr)
        elif groups:
            tests.append((seconds, name, groups))
    return tests


def holder(binary, tests, variant, seconds):
    """The first test that fails with the variant."""
    batch, batch_s, spent = [], 0.0, 0.0
    for took, name, _ in [*tests, (float("inf"), None, None)]:
        if batch and (name is None or batch_s + took > BATCH_S):
            # One that fails among others fails by itself, too, or it is not what holds the threshold.
            for failed in run(binary, batch, variant, timeout=30 + 20 * batch_s):
                if run(binary, [failed], variant, timeout=30 + 20 * batch_s):
                    return failed
            spent += batch_s
            batch, batch_s = [], 0.0
        if name is None or spent + took > seconds:
            break
        batch.append(name)
        batch_s += took
    return None


def variants_of(binary, factor):
    """Name, way and value of both variants of each threshold."""
    listing = [binary, "--exact", "--ignored", "--nocapture", "studies::limits::values::tests::every_variant"]
    listed = subprocess.run(listing, check=True, stdout=subprocess.PIPE, text=True).stdout
    variants = re.findall(r"^variant (\S+) (\S+) (\S+) of (\S+)$", listed, re.M)
    if factor == 2.0:
        return [v[:3] for v in variants]
    names = dict((name, float(value)) for name, _, _, value in variants)
    return [(n, way, repr(v * f)) for n, v in names.items() for way, f in (("least", 1 / factor), ("most", factor))]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--only", default="", help="part of the thresholds' names, or names joined by commas")
    arguments.add_argument("--factor", type=float, default=1e6, help="2 for half and double")
    arguments.add_argument("--seconds", type=float, default=20.0)
    arguments.add_argument("--both", action="store_true", help="the other way, too, of a threshold that is held")
    arguments.add_argument("--jobs", type=int, default=2)
    arguments.add_argument("--csv")
    arguments.add_argument("--binary")
    arguments.add_argument("--survey", help="keep what each test reads in this file")
    given = arguments.parse_args()
    binary = given.binary or test_binary()
    if given.survey and os.path.exists(given.survey):
        tests = [(s, n, set(g)) for s, n, g in json.load(open(given.survey))]
    else:
        tests = survey(binary)
        if given.survey:
            json.dump([(s, n, sorted(g)) for s, n, g in tests], open(given.survey, "w"))
    tests.sort(key=lambda t: (len(t[2]), t[0]))
    print(f"{len(tests)} tests read thresholds, {sum(t[0] for t in tests):.0f} s", file=sys.stderr)
    only = given.only.split(",")
    variants = [v for v in variants_of(binary, given.factor) if any(o in v[0] for o in only)]

    by_name = {}
    for name, way, value in variants:
        by_name.setdefault(name, []).append((way, value))
    rows = []
    if given.csv and os.path.exists(given.csv):
        rows = [tuple(r) for r in list(csv.reader(open(given.csv, newline="")))[1:]]
    known = {r[0] for r in rows}

    def rows_of(name):
        found, group = [], name.split(".")[0]
        of_group = [t for t in tests if group in t[2]]
        for way, value in by_name[name]:
            test = holder(binary, of_group, f"{name}={value}", given.seconds)
            found.append((name, way, value, test or "-"))
            if test and not given.both:
                break
        return found

    with ThreadPoolExecutor(given.jobs) as pool:
        for found in pool.map(rows_of, [n for n in by_name if n not in known]):
            rows += found
            for row in found:
                print(*row, flush=True)
            if given.csv:
                with open(given.csv, "w", newline="") as file:
                    csv.writer(file).writerows([("threshold", "way", "value", "test"), *rows])


if __name__ == "__main__":
    main()
