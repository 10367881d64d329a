"""Charted marks in the picture: they add to AIS aids, confirm or refute them, and only those in reach take part."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from navfix.errors import TooFewPairs
from navfix.geodesy import direct
from navfix.nmea.records import AisPosition, Record, TargetReport
from navfix.picture import Picture
from navfix.picture.charted import ChartedMarks, common_shift, same_name
from navfix.report import Answer
from navfix.report.data_used import data_entries
from navfix.report.fix_json import answer_to_dict
from navfix.types import Epoch, Mark, OffStation, Position

T0 = datetime(2026, 1, 1, tzinfo=UTC).timestamp()
HERE = Position(54.0, 8.0)
BUOY = 992001001


def aid(position: Position, mmsi: int = BUOY, **more: object) -> AisPosition:
    told = {"aid_type": 24, "name": "BUOY 1"} | more
    return AisPosition(T0, mmsi, 21, "aton", position.lat_deg, position.lon_deg, **told)


def ship(position: Position, mmsi: int = 200100001) -> AisPosition:
    return AisPosition(T0, mmsi, 1, "ship", position.lat_deg, position.lon_deg, speed_mps=0.0, ais_class="A")


def charted(position: Position, label: str = "C1", **more: object) -> Mark:
    return Mark(label, position, 15.0, "charted", **more)


def epoch_of(records: list[Record], marks: list[Mark], range_m: float = 5000.0) -> Epoch:
    picture = Picture(charted=marks)
    for record in records:
        picture.feed(record)
    picture.feed(TargetReport(T0, 1, range_m, 10.0, "relative"))
    scan = picture.feed(TargetReport(T0 + 3.0, 1, range_m, 10.0, "relative"))
    assert scan is not None
    return picture.epoch(scan)


def test_without_a_chart_nothing_is_said_of_it() -> None:
    assert epoch_of([aid(HERE)], []).chart is None


def test_a_charted_mark_that_ais_does_not_show_is_added() -> None:
    epoch = epoch_of([ship(HERE)], [charted(direct(HERE, 90.0, 3000.0))])
    assert [mark.kind for mark in epoch.marks] == ["ship", "charted"]
    assert epoch.chart is not None
    assert (epoch.chart.charted, epoch.chart.in_reach, epoch.chart.added) == (1, 1, 1)


def test_an_aid_near_its_charted_place_is_confirmed_and_is_one_mark() -> None:
    epoch = epoch_of([aid(direct(HERE, 45.0, 30.0))], [charted(HERE)])
    (mark,) = epoch.marks
    assert (mark.kind, mark.mmsi, mark.position, mark.sigma_m, mark.name) == ("charted", BUOY, HERE, 15.0, "BUOY 1")
    assert epoch.chart is not None
    assert (epoch.chart.confirmed, epoch.chart.added, epoch.chart.off_station) == ((BUOY,), 0, ())


@pytest.mark.parametrize("known", [{"mmsi": BUOY}, {"name": "Buoy 1"}])
def test_an_aid_off_station_is_left_out_with_its_charted_mark_and_reported(known: dict[str, object]) -> None:
    epoch = epoch_of([aid(direct(HERE, 90.0, 800.0)), ship(HERE)], [charted(HERE, **known)])
    assert [mark.kind for mark in epoch.marks] == ["ship"]
    assert epoch.chart is not None
    (off,) = epoch.chart.off_station
    assert off.distance_m == pytest.approx(800.0, abs=0.1)
    assert off.azimuth_deg == pytest.approx(90.0, abs=0.1)
    assert dict(epoch.left_out) == {"aid off station": 1}


def test_an_aid_with_a_charted_mmsi_is_off_station_however_far_it_is() -> None:
    epoch = epoch_of([aid(direct(HERE, 90.0, 30_000.0))], [charted(HERE, mmsi=BUOY)])
    assert epoch.marks == ()
    assert epoch.chart is not None
    assert len(epoch.chart.off_station) == 1


def test_an_mmsi_says_more_than_a_place() -> None:
    there = direct(HERE, 90.0, 900.0)
    marks = [charted(HERE, "C1", mmsi=BUOY), charted(there, "C2", name="Other")]
    epoch = epoch_of([aid(there)], marks)
    assert epoch.chart is not None
    assert [off.charted for off in epoch.chart.off_station] == ["C1"]
    assert [mark.label for mark in epoch.marks] == ["C2"]


def test_an_aid_that_says_it_is_off_position_takes_its_charted_mark_with_it() -> None:
    records = [aid(direct(HERE, 0.0, 20.0), off_position=True, utc_second=5)]
    epoch = epoch_of(records, [charted(HERE, name="BUOY 1")])
    assert epoch.marks == ()
    assert epoch.chart is not None
    assert [off.flagged for off in epoch.chart.off_station] == [True]


@pytest.mark.parametrize("wrong", [{"virtual": True}, {"mmsi": 992006001}, {"aid_type": 0}, {"aid_type": 1}])
def test_a_virtual_or_unspecified_aid_counts_only_where_one_is_charted(wrong: dict[str, object]) -> None:
    record = replace(aid(direct(HERE, 0.0, 20.0)), **wrong)
    far = charted(direct(HERE, 90.0, 2000.0), "far", name="X")
    refused = epoch_of([record], [far])
    assert [mark.label for mark in refused.marks] == ["far"] if refused.chart and refused.chart.in_reach else True
    assert sum(dict(refused.left_out).values()) == 1
    taken = epoch_of([record], [charted(HERE), far])
    assert {mark.label for mark in taken.marks} >= {"C1"}
    assert taken.chart is not None
    assert taken.chart.confirmed == (record.mmsi,)
    assert taken.left_out == ()


def test_a_virtual_aid_of_the_same_name_far_away_refutes_nothing() -> None:
    epoch = epoch_of([aid(direct(HERE, 0.0, 900.0), virtual=True)], [charted(HERE, name="BUOY 1")])
    assert [mark.label for mark in epoch.marks] == ["C1"]
    assert epoch.chart is not None
    assert epoch.chart.off_station == ()


def test_an_aid_that_is_not_charted_stays_and_is_told() -> None:
    epoch = epoch_of([aid(direct(HERE, 0.0, 3000.0))], [charted(HERE, name="Other")])
    assert {mark.label for mark in epoch.marks} == {str(BUOY), "C1"}
    assert epoch.chart is not None
    assert epoch.chart.not_charted == (BUOY,)


def test_a_nameless_charted_mark_near_by_makes_an_aid_doubtful_and_stays_itself() -> None:
    epoch = epoch_of([aid(direct(HERE, 0.0, 250.0))], [charted(HERE)])
    assert [mark.label for mark in epoch.marks] == ["C1"]
    assert epoch.chart is not None
    assert len(epoch.chart.off_station) == 1


def test_each_charted_mark_confirms_one_aid_only() -> None:
    records = [aid(direct(HERE, 0.0, 5.0), BUOY, name=None), aid(direct(HERE, 0.0, 25.0), BUOY + 1, name=None)]
    epoch = epoch_of(records, [charted(HERE, name="Only")])
    assert epoch.chart is not None
    assert epoch.chart.confirmed == (BUOY,)
    assert epoch.chart.not_charted == (BUOY + 1,)


def test_only_marks_within_twice_the_radar_range_of_an_ais_mark_take_part() -> None:
    marks = [charted(direct(HERE, 90.0, 1000.0 * k), f"C{k}") for k in range(30)]
    few = epoch_of([ship(HERE)], marks, range_m=5000.0)  # own ship may be near none of a few AIS ships
    assert sum(mark.kind == "charted" for mark in few.marks) == 30
    ships = [ship(direct(HERE, 270.0, 10.0 * k), 200100001 + k) for k in range(10)]
    epoch = epoch_of(ships, marks, range_m=5000.0)
    assert sorted(mark.label for mark in epoch.marks if mark.kind == "charted") == sorted(f"C{k}" for k in range(11))


def test_without_ais_every_charted_mark_takes_part() -> None:
    epoch = epoch_of([], [charted(direct(HERE, 90.0, 1000.0 * k), f"C{k}") for k in range(30)])
    assert len(epoch.marks) == 30


def test_thousands_of_charted_marks_are_cut_to_the_nearest() -> None:
    rng = np.random.default_rng(1)
    marks = [
        charted(Position(54.0 + float(lat), 8.0 + float(lon)), f"C{i}", name=f"N{i}")
        for i, (lat, lon) in enumerate(rng.uniform(-0.2, 0.2, (6000, 2)))
    ]
    ships = [Mark(f"s{k}", HERE, 10.0) for k in range(10)]
    near = ChartedMarks(marks)
    joined = near.join(ships, [(aid(direct(HERE, 0.0, 50.0), name="N7"), None)], {}, 30_000.0)
    assert joined.check.in_reach <= 1501
    assert len(joined.marks) <= 1511


def test_an_aid_off_station_stands_in_the_report_and_in_the_json() -> None:
    epoch = epoch_of([aid(direct(HERE, 90.0, 800.0)), ship(HERE)], [charted(HERE, name="Buoy 1")])
    entries = list(data_entries(epoch))
    assert ("", "- BUOY 1 (992001001) off station by AIS: 800 m along 090° from charted Buoy 1; left out") in entries
    assert dict(entries)["Chart"] == (
        "1 of 1 charted mark in reach: 0 added to AIS, 0 confirm an AIS aid, 1 off station"
    )
    content = answer_to_dict(Answer(epoch=epoch, error=TooFewPairs("few", observations=2, unknowns=3)))
    assert content["chart"]["off_station"][0]["mmsi"] == BUOY
    assert content["chart"]["shift_m"] is None
    assert content["choice"]["decision"] == "all"


def test_aids_off_station_alike_tell_the_common_vector_and_buoys_adrift_do_not() -> None:
    def off(distance_m: float, azimuth_deg: float, flagged: bool = False) -> OffStation:
        return OffStation(BUOY, None, "C", distance_m, azimuth_deg, flagged)

    distance_m, azimuth_deg = common_shift([off(200.0, 120.0), off(210.0, 122.0), off(900.0, 10.0)])
    assert distance_m == pytest.approx(205.0, abs=1.0)
    assert azimuth_deg == pytest.approx(121.0, abs=0.5)
    assert common_shift([off(200.0, 120.0)]) == (None, None)
    assert common_shift([off(200.0, 120.0), off(200.0, 300.0)]) == (None, None)
    assert common_shift([off(200.0, 120.0), off(200.0, 120.0, True)]) == (None, None)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("Buoy 1", "BUOY 1", True),
        ("Wyk No. 7-A", "WYK NO 7A", True),
        ("7", "7", False),
        ("Elbe approach north cardinal buoy", "ELBE APPROACH NORTH ", True),
        ("Buoy 10", "BUOY 1", False),
        ("", "BUOY 1", False),
        (None, None, False),
        ("---", "***", False),
    ],
)
def test_names_are_the_same_by_letters_and_digits_as_far_as_ais_spells(
    one: str | None, other: str | None, same: bool
) -> None:
    assert same_name(one, other) is same
