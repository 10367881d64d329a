"""While radar is silent there are epochs without targets: in order, seldom, none before radar was heard."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

from navfix.nmea.records import OwnHeading, TargetReport
from navfix.picture import epochs

BEGIN_S = datetime(2026, 1, 1, tzinfo=UTC).timestamp()


def report(second: float, number: int = 1, turn: int = 0) -> TargetReport:
    return TargetReport(
        time_s=BEGIN_S + second, talker="RA", number=number, range_m=3000.0 + turn, bearing_deg=40.0,
        bearing_reference="relative",
    )  # fmt: skip


def gyro(second: float) -> OwnHeading:
    return OwnHeading(time_s=BEGIN_S + second, heading_deg=10.0, reference="true", sentence="HDT")


def log(*, silent: tuple[float, float], until: float = 400.0, turn_s: float = 3.0):
    records = [gyro(float(s)) for s in range(-60, int(until))]
    count = int(until / turn_s) + 1
    for turn in range(count):
        second = turn * turn_s + 0.5
        if not silent[0] <= second < silent[1]:
            records += [report(second + 0.1 * n, n, turn) for n in (1, 2, 3)]
    return sorted(records, key=lambda record: record.time_s)


def seconds(found):
    return [epoch.time_utc.timestamp() - BEGIN_S for epoch in found]


def test_a_silence_of_radar_has_empty_epochs_and_they_come_in_order():
    with_silence = list(epochs(log(silent=(100.0, 300.0)), silent_s=5.0))
    without = list(epochs(log(silent=(100.0, 300.0))))
    empty = [epoch for epoch in with_silence if not epoch.targets]
    assert seconds(with_silence) == sorted(seconds(with_silence))
    assert [t for t in seconds(with_silence) if t not in seconds(empty)] == seconds(without)
    assert 110.0 < seconds(empty)[0] < 115.0
    assert 294.0 < seconds(empty)[-1] < 301.0
    assert {round(b - a) for a, b in zip(seconds(empty), seconds(empty)[1:], strict=False)} == {5}
    assert all(epoch.heading_hint is not None for epoch in empty)
    assert min(seconds(empty)) > 0.0, "none before radar was heard"


@pytest.mark.parametrize("turn_s", [1.3, 3.0, 11.0])
def test_a_slow_antenna_is_not_silent(turn_s: float):
    found = list(epochs(log(silent=(999.0, 999.0), turn_s=turn_s), silent_s=5.0))
    assert all(epoch.targets for epoch in found)
    assert len(found) > 25


def test_a_clock_that_was_set_back_is_another_recording_and_its_scans_count():
    twice = [*log(silent=(100.0, 200.0), until=150.0), *log(silent=(999.0, 999.0), until=60.0)]
    found = list(epochs(twice, silent_s=5.0))
    back = next(k for k, (a, b) in enumerate(zip(seconds(found), seconds(found)[1:], strict=False)) if b < a)
    assert len(found[back + 1 :]) >= 18
    assert all(epoch.targets for epoch in found[back + 1 :])
