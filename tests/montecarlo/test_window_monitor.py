"""The monitor of GNSS fed with fixes of sliding windows or of the navigator: 15 pairs, gyro and log, 60 s."""

from __future__ import annotations

import numpy as np
import pytest

from tests.alarm_scenes import STEP_S, alarm_s, drag_off, jump, navigator_alarm_s, quiet_hours


def test_a_jump_of_200_m_alarms_at_the_second_turn() -> None:
    assert alarm_s(1, 6, 4, jump) == (STEP_S, 0)


def test_a_jump_of_200_m_alarms_within_three_turns_in_the_whole_navigator() -> None:
    since_s, early = navigator_alarm_s(1, 2, 4, jump)
    assert since_s <= 2.0 * STEP_S
    assert early == 0


@pytest.mark.study
def test_study_of_jump_and_drag_off_with_windows() -> None:
    jumps = [alarm_s(seed, 10, 6, jump) for seed in range(20)]
    drags = [alarm_s(seed, 100, 50, drag_off) for seed in range(8)]
    for name, found in (("jump 200 m", jumps), ("drag 1 m/s", drags)):
        times = np.array([alarm for alarm, _ in found])
        print(
            f"{name}: median {np.median(times):.0f} s, most {times.max():.0f} s; before it {sum(e for _, e in found)}"
        )
    assert max(alarm for alarm, _ in jumps) <= STEP_S
    assert max(alarm for alarm, _ in drags) <= 120.0
    assert sum(early for _, early in (*jumps, *drags)) == 0


@pytest.mark.study
def test_study_of_hours_without_a_false_alarm() -> None:
    hours = 0.0
    for seed in range(12):
        spent, alarms = quiet_hours(500 + seed, 200)
        hours += spent
        assert alarms == 0
    print(f"{hours:.1f} simulated hours of windows without an alarm")
