"""When an AIS position held: its second of the minute, a slow clock of the log, stations with clocks of their own."""

from __future__ import annotations

from collections import deque

import pytest

from navfix.picture.time_base import AisClock, circular_median, delay, position_time

T0 = 1_700_000_040.0  # a full minute


def fed(clock: AisClock, delays_s, *, mmsi: int = 1, count: int = 60, start_s: float = T0) -> list[float]:
    """Feed reports whose positions held at whole seconds and were received later; return position_time - truth."""
    found = []
    for k in range(count):
        held = start_s + 7.0 * k
        late = delays_s[k % len(delays_s)]
        found.append(clock.position_time(mmsi, held + late, int(held % 60.0)) - held)
    return found


def test_a_minute_has_its_second_at_both_ends():
    assert delay(T0 + 1.0, 59) == pytest.approx(2.0)
    assert delay(T0 - 1.0, 1) == pytest.approx(-2.0)
    assert position_time(T0 + 0.4, 59) == pytest.approx(T0 - 1.0)
    assert position_time(T0 + 25.0, 0) == T0 + 25.0


def test_receptions_late_by_anything_up_to_a_slow_network_do_not_move_the_position():
    for delays in ([0.2, 0.9, 2.4], [8.0, 12.0, 10.0], [-0.8, -0.2]):
        clock = AisClock()
        assert fed(clock, delays) == pytest.approx([0.0] * 60)
        assert (clock.offset_s, clock.scatter_s) == (0.0, 0.0)


def test_a_log_that_shows_positions_before_they_held_is_timed_by_its_receptions_with_their_scatter():
    clock = AisClock()
    found = fed(clock, [-9.0, -6.0, -5.0, -8.0, -7.0], count=100)
    assert clock.offset_s == pytest.approx(-7.0)
    assert 1.0 < clock.scatter_s < 2.5
    assert found[-5:] == pytest.approx([-9.0, -6.0, -5.0, -8.0, -7.0])


def test_a_station_whose_own_clock_is_off_is_evened_out_and_the_others_stay():
    clock = AisClock()
    fed(clock, [0.5], mmsi=1)
    odd = fed(clock, [16.2, 15.8, 16.0, 17.0], mmsi=2)
    assert max(odd[-8:]) - min(odd[-8:]) < 0.5
    assert fed(clock, [0.5], mmsi=1, count=5) == pytest.approx([0.0] * 5)


def test_without_a_second_the_reception_counts():
    assert AisClock().position_time(1, T0 + 3.3, None) == T0 + 3.3


def test_the_median_goes_round_the_minute():
    assert circular_median(deque([29.0, -30.0, -29.0])) == pytest.approx(-30.0)
    assert circular_median(deque([-1.0, 0.0, 1.0])) == pytest.approx(0.0)
