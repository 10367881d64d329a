"""Time to alarm of the GNSS monitor with fixes of windows: a jump, a drag-off, and hours in which nothing is wrong.

    python tests/benchmarks/bench_alarm.py [--seeds N] [--hours H] [--navigator]

15 pairs, gyro and log, windows of 60 s, a scan every 3 s; every window is adjusted. 24 h take half an hour of CPU. With
--navigator the whole navigator gives the fixes, from a cold start and with pairs that it finds itself.
"""

from __future__ import annotations

import argparse

import numpy as np

from tests.alarm_scenes import STEP_S, alarm_s, drag_off, jump, navigator_alarm_s, quiet_hours

QUIET_SCANS = 300


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=8, help="passages with a jump; half as many with a drag-off")
    parser.add_argument("--hours", type=float, default=0.5, help="simulated hours with nothing wrong")
    parser.add_argument("--navigator", action="store_true", help="fixes of the whole navigator")
    args = parser.parse_args()
    alarm = navigator_alarm_s if args.navigator else alarm_s
    print("| GNSS | runs | median s | most s | radar turns at most | false alarms before |\n|---|---|---|---|---|---|")
    for name, offset, quiet, scans, runs in (
        ("jump of 200 m", jump, 10, 6, args.seeds),
        ("dragged off, 1 m/s", drag_off, 30, 50, max(args.seeds // 2, 1)),
    ):
        found = [alarm(seed, quiet, scans, offset) for seed in range(runs)]
        times, early = np.array([time for time, _ in found]), sum(count for _, count in found)
        turns = times.max() / STEP_S + 1.0  # the first scan with the offset counts
        print(f"| {name} | {runs} | {np.median(times):.0f} | {times.max():.0f} | {turns:.0f} | {early} |", flush=True)
    hours, alarms, seed = 0.0, 0, 500
    while hours < args.hours:
        spent, false = quiet_hours(seed, QUIET_SCANS, alarm)
        hours, alarms, seed = hours + spent, alarms + false, seed + 1
    print(f"\n{hours:.1f} simulated hours with nothing wrong: {alarms} false alarms")


if __name__ == "__main__":
    main()
