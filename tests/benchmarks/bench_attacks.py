"""The navigator under attack, counted over seeds: wrong places given out, the longest hold, and the doubt stated.

    python tests/benchmarks/bench_attacks.py                          one seed of each attack
    python tests/benchmarks/bench_attacks.py --seeds 10 --first 6000  ten of each

Prints a table in Markdown: a row per attack, as soon as it is known. "Stated" is the sum of the probabilities of being
wrong that stood beside the fixes: no more of them may be wrong. A step is 10 s.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests import hostile_scenes as hostile
from tests.hostile_scenes import Scene, Told, tell

Attack = Callable[[int], Told]


def _changed(change: hostile.Change, after_s: float = 100.0) -> Attack:
    return lambda seed: tell(hostile.scene(seed).changed(change, after_s=after_s))


def _for_a_while(change: hostile.Change, for_s: float) -> Attack:
    return lambda seed: tell(hostile.scene(seed).changed(change, after_s=100.0, for_s=for_s))


def _radar_off(seed: int) -> Told:
    """Switch the radar off for 40 s; its tracker begins anew."""
    found = hostile.scene(seed).changed(hostile.renumber, after_s=100.0)
    return tell(found.changed(hostile.lose_echoes(1.0), after_s=100.0, for_s=40.0))


def _wrong_state(believed: bool) -> Attack:
    def attack(seed: int) -> Told:
        found = hostile.scene(seed)
        return tell(found, hostile.wrong_state(found, 4000.0, -3000.0, believed=believed))

    return attack


def _gyro(off_deg: float) -> Attack:
    def attack(seed: int) -> Told:
        found: Scene = hostile.scene(seed)
        return tell(found.changed(hostile.gyro_off(found.truth, off_deg)))

    return attack


ATTACKS: dict[str, Attack] = {
    "none": lambda seed: tell(hostile.scene(seed)),
    "all AIS jump by 300 m": _changed(hostile.jump(180.0, -240.0)),
    "all AIS jump by 600 m": _changed(hostile.jump(360.0, -480.0)),
    "all AIS jump by 1500 m": _changed(hostile.jump(900.0, -1200.0)),
    "all AIS jump by 1500 m, for 15 min": lambda seed: tell(
        hostile.scene(seed, duration_s=1000.0).changed(hostile.jump(900.0, -1200.0), after_s=100.0)
    ),
    "a third of the ships spoofed by 1500 m": _changed(hostile.spoofed_cluster(0.35, 1500.0, 0.0)),
    "half of the ships spoofed by 1500 m": _changed(hostile.spoofed_cluster(0.5, 1500.0, 0.0)),
    "target numbers swapped": _changed(hostile.swap_numbers),
    "wrong state given": _wrong_state(False),
    "wrong state believed": _wrong_state(True),
    "restart": lambda seed: tell(hostile.scene(seed).later(100.0)),
    "across 180 E": lambda seed: tell(hostile.scene(seed, lat_deg=-16.8, lon_deg=179.995)),
    "at 80 N": lambda seed: tell(hostile.scene(seed, lat_deg=80.0)),
    "sparse: 3 ships, 12 other echoes": lambda seed: tell(hostile.scene(seed, ships=3, dumb=12)),
    "gyro 90 deg off": _gyro(90.0),
    "tracker restarts": _changed(hostile.renumber),
    "radar off for 40 s": _radar_off,
    "half of the echoes lost for 40 s": _for_a_while(hostile.lose_echoes(0.5), 40.0),
    "no AIS for 60 s": _for_a_while(hostile.silence, 60.0),
    "own ship turns by 90 deg, 1 deg/s": lambda seed: tell(hostile.scene(seed, turn_degps=1.0)),
    "own ship turns by 90 deg, 3 deg/s": lambda seed: tell(hostile.scene(seed, turn_degps=3.0)),
}
HEAD = (
    "| attack | runs | steps | fixes | ellipse holds % | wrong > 500 m | stated | longest wrong hold s | worst m "
    "| least doubt if wrong |"
)


def rows(seeds: range, only: str = "") -> Iterator[str]:
    """Yield the rows of the table, of the attacks whose name holds ``only``."""
    yield HEAD
    yield "|---" * HEAD.count(" |") + "|"
    for name, attack in ((name, attack) for name, attack in ATTACKS.items() if only in name):
        told = [attack(seed) for seed in seeds]
        hostile.scene.cache_clear()
        wrong, fixes = sum(t.wrong for t in told), sum(t.fixes for t in told)
        held = f"{100.0 * sum(t.inside for t in told) / fixes:.0f}" if fixes else "-"
        least = f"{min(t.surest_wrong for t in told):.3f}" if wrong else "-"
        yield (
            f"| {name} | {len(told)} | {sum(t.steps for t in told)} | {fixes} | {held} | {wrong} "
            f"| {sum(t.expected_wrong for t in told):.1f} | {hostile.longest_wrong_s(told):.0f} "
            f"| {max(t.worst_m for t in told):.0f} | {least} |"
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1, help="runs of each attack")
    parser.add_argument("--first", type=int, default=6000, help="the first seed")
    parser.add_argument("--only", default="", help="attacks whose name holds this")
    args = parser.parse_args()
    for row in rows(range(args.first, args.first + args.seeds), args.only):
        print(row, flush=True)


if __name__ == "__main__":
    main()
