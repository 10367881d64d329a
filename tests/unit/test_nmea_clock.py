"""The time line of logs without time stamps."""

from __future__ import annotations

from navfix.nmea.clock import DAY_S, SentenceClock

NOON_S = 1_438_000_000.0 // DAY_S * DAY_S + 43200.0


def test_before_any_time_there_is_none() -> None:
    assert (SentenceClock().now_s, SentenceClock().basis) == (None, "none")


def test_dated_sentences_are_followed() -> None:
    clock = SentenceClock()
    for step in range(5):
        clock.dated(NOON_S + step, speaker="GPRMC")
        assert clock.now_s == NOON_S + step
    assert clock.basis == "sentence"


def test_times_of_day_roll_over_midnight() -> None:
    clock = SentenceClock()
    seen = []
    for utc_of_day_s in (86398.0, 86399.0, 0.0, 1.0, 2.0):
        clock.time_of_day(utc_of_day_s, rank=2, speaker="RATTM")
        seen.append(clock.now_s)
    assert seen == [86398.0, 86399.0, 86400.0, 86401.0, 86402.0]
    assert clock.basis == "time_of_day"


def test_three_days_of_times_of_day_are_three_days() -> None:
    clock = SentenceClock()
    for second in range(0, 3 * 86400, 60):
        clock.time_of_day(second % 86400, rank=1, speaker="GPGGA")
        assert clock.now_s == second


def test_a_late_sentence_from_before_midnight_does_not_jump_a_day() -> None:
    clock = SentenceClock()
    clock.time_of_day(86399.0, rank=1, speaker="GPGGA")
    clock.time_of_day(0.5, rank=1, speaker="GPGGA")
    clock.time_of_day(86399.9, rank=1, speaker="GPGLL")
    assert clock.now_s == 86400.5


def test_a_date_that_comes_later_gives_the_day() -> None:
    clock = SentenceClock()
    clock.time_of_day(43200.0, rank=1, speaker="GPGGA")
    clock.dated(NOON_S + 1.0, speaker="GPRMC")
    assert (clock.now_s, clock.basis) == (NOON_S + 1.0, "sentence")
    clock.time_of_day(43202.0, rank=1, speaker="GPGGA")
    assert clock.now_s == NOON_S + 1.0  # RMC leads while it speaks


def test_the_leader_is_not_disturbed_by_a_radar_clock_that_is_a_minute_off() -> None:
    clock = SentenceClock()
    for step in range(100):
        clock.dated(NOON_S + step, speaker="GPRMC")
        clock.time_of_day(43200.0 + step + 60.0, rank=2, speaker="RATTM")
        assert clock.now_s == NOON_S + step


def test_when_the_gnss_falls_silent_the_radar_clock_takes_over() -> None:
    clock = SentenceClock()
    for step in range(20):
        clock.dated(NOON_S + step, speaker="GPRMC")
        clock.time_of_day(43200.0 + step, rank=2, speaker="RATTM")
    for step in range(20, 100):
        clock.time_of_day(43200.0 + step, rank=2, speaker="RATTM")
    assert clock.now_s == NOON_S + 99.0


def test_a_gnss_that_repeats_one_time_counts_as_silent() -> None:
    clock = SentenceClock()
    clock.dated(NOON_S, speaker="GPRMC")
    times = []
    for step in range(100):
        clock.dated(NOON_S, speaker="GPRMC")
        clock.time_of_day(43200.0 + step, rank=2, speaker="RATTM")
        times.append(clock.now_s)
    assert times[-1] == NOON_S + 99.0
    assert times == sorted(times)


def test_the_gnss_leads_again_when_it_is_back() -> None:
    clock = SentenceClock()
    clock.dated(NOON_S, speaker="GPRMC")
    for step in range(60):
        clock.time_of_day(43200.0 + step + 5.0, rank=2, speaker="RATTM")  # five seconds fast
    for step in range(60, 120):
        clock.dated(NOON_S + step, speaker="GPRMC")
        clock.time_of_day(43200.0 + step + 5.0, rank=2, speaker="RATTM")
    assert clock.now_s == NOON_S + 119.0


def test_a_new_recording_may_begin_earlier() -> None:
    clock = SentenceClock()
    clock.dated(NOON_S, speaker="GPRMC")
    clock.dated(NOON_S - 30 * DAY_S, speaker="GPRMC")
    assert clock.now_s == NOON_S - 30 * DAY_S


def test_a_second_receiver_with_a_wrong_date_changes_nothing() -> None:
    clock = SentenceClock()
    for step in range(10):
        clock.dated(NOON_S + step, speaker="GPZDA")
        clock.dated(NOON_S + step - 7168 * DAY_S, speaker="GPRMC")  # 1024 weeks: the roll-over of GPS
        assert clock.now_s == NOON_S + step


def test_one_wild_time_of_day_moves_nothing() -> None:
    clock = SentenceClock()
    for told in (100.0, 101.0, 900.0, 102.0, 103.0):
        clock.time_of_day(told, rank=2, speaker="RATTM")
    assert clock.now_s == 103.0


def test_a_gap_in_the_recording_is_believed_when_it_is_told_twice() -> None:
    clock = SentenceClock()
    for told in (100.0, 101.0, 900.0, 901.0):
        clock.time_of_day(told, rank=2, speaker="RATTM")
    assert clock.now_s == 901.0


def test_a_start_known_beforehand_gives_the_day() -> None:
    clock = SentenceClock(NOON_S + 43190.0)
    clock.time_of_day(5.0, rank=1, speaker="GPGGA")
    assert (clock.now_s, clock.basis) == (NOON_S + 43205.0, "sentence")
