#!/usr/bin/env python3
"""A controller of your own for `shadowgauge study controllers`, in Python's standard library alone.

    shadowgauge study controllers --shafts 2 --with-command "python3 examples/controller.py --kp 0.9"

Every line on stdin is a JSON object: `begin` once, `pass` after every pass, `end` at the end. Every
`pass` is answered by one line on stdout; remarks go to stderr. docs/controllers.md lists all keys.

The law is proportional-integral at every station: the offsets change by kp times the error just
measured, and by ki times the sum of all errors of the part so far.
"""

import argparse
import json
import sys


def errors(message):
    """Error D - r of every station in mm of diameter; None where the gauge has no reading."""
    nominal = message["nominal_mm"]
    readings = [station["reading"].get("value") for station in message["stations"]]
    return [None if value is None else value["d_mm"] - nominal for value in readings]


def main():
    options = argparse.ArgumentParser(description="proportional-integral offsets, station by station")
    options.add_argument("--kp", type=float, default=0.9, help="share of an error corrected at once")
    options.add_argument("--ki", type=float, default=0.1, help="share of the summed errors added to it")
    gains = options.parse_args()

    sums = []
    before = []
    # readline, not iteration over stdin: a loop over the file may wait for more than one line.
    for line in iter(sys.stdin.readline, ""):
        message = json.loads(line)
        if message["type"] == "begin":
            if message["version"] != 1:
                sys.exit(f"version {message['version']} of the protocol; this program has 1")
            sums = [0.0] * len(message["station_z_mm"])
        elif message["type"] == "pass":
            if message["held"] is not None:
                sums = before  # the last reply was not put in force: as if it had not been asked for
            before = list(sums)
            error = errors(message)
            if None in error:
                reply = {"hold": f"no reading at station {error.index(None) + 1}"}
            else:
                sums = [s + e for s, e in zip(sums, error)]
                # A diameter too large needs a larger offset: the command is nominal less offset.
                offsets = [
                    o + (gains.kp * e + gains.ki * s)
                    for o, e, s in zip(message["offsets_mm"], error, sums)
                ]
                reply = {"pass": message["pass"], "offsets_mm": offsets}
            # flush, or the line stays in a buffer and the study waits for it in vain
            print(json.dumps(reply), flush=True)
        elif message["type"] == "end":
            break


if __name__ == "__main__":
    main()
