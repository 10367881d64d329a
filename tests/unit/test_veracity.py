"""AIS against radar over time: true ships agree, false ones are named with their offset, and nobody without proof."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix import adjust
from navfix.geodesy import LocalPlane
from navfix.integrity import AisVeracity
from navfix.integrity.drift import ErrorModel
from navfix.integrity.sightings import sightings
from navfix.integrity.veracity import VeracitySettings
from navfix.report.veracity import SCHEMA, veracity_json, veracity_rows, veracity_text
from navfix.types import Association, Epoch, Fix, Hull, Mark, Position, RadarTarget, ShipVeracity

OWN = Position(54.5, 18.8)
START = datetime(2026, 5, 1, tzinfo=UTC)
PLANE = LocalPlane(OWN)
HEADING_DEG, STEP_S, SHIPS = 40.0, 6.0, 12
LARGE = Hull(100.0, 50.0, 12.0, 12.0)
Shift = Callable[[int, np.ndarray], np.ndarray]


def fixes(
    shift: dict[int, tuple[float, float]],
    *,
    epochs: int = 40,
    unpaired: tuple[int, ...] = (),
    without_echo: tuple[int, ...] = (),
    noise: float = 1.0,
    reference: str = "relative",
    late_s: float = 0.0,
    velocity_mps: float = 6.0,
) -> Iterator[Fix]:
    """Twelve ships about own ship for some minutes; the AIS of some is shifted by (north, east) [m]."""
    rng = np.random.default_rng(8)
    azimuth = np.linspace(0.0, 2.0 * math.pi, SHIPS, endpoint=False)
    start = rng.uniform(2000.0, 4500.0, SHIPS)[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    course = rng.permutation(SHIPS) * 2.0 * math.pi / SHIPS
    velocity = velocity_mps * np.stack([np.cos(course), np.sin(course)], axis=-1)
    antenna = noise * 8.0 * rng.normal(size=(SHIPS, 2))
    for epoch in range(epochs):
        place = start + velocity * STEP_S * epoch
        targets, marks, pairs = [], [], []
        for k in range(SHIPS):
            claimed = place[k] + antenna[k] + shift.get(k, (0.0, 0.0))
            claimed = claimed - velocity[k] * late_s * (k == 3)
            course_deg = math.degrees(course[k]) % 360.0
            position = PLANE.to_position(*claimed)
            mark = Mark(
                f"ship {k}", position, 10.0, mmsi=1000 + k, speed_mps=velocity_mps, course_deg=course_deg, hull=LARGE
            )
            marks.append(mark)
            if k in without_echo:
                continue
            range_m, true_deg = np.hypot(*place[k]), math.degrees(math.atan2(place[k, 1], place[k, 0]))
            targets.append(
                RadarTarget(
                    f"{k:02d}",
                    range_m + noise * 20.0 * rng.normal(),
                    true_deg - (HEADING_DEG if reference == "relative" else 0.0) + noise * 0.4 * rng.normal(),
                    reference,  # type: ignore[arg-type]
                    range_sigma_m=20.0,
                    bearing_sigma_deg=0.4,
                )
            )
            if k not in unpaired:
                pairs.append((f"{k:02d}", f"ship {k}"))
        scene = Epoch(START + timedelta(seconds=STEP_S * epoch), tuple(targets), tuple(marks))
        yield adjust(scene, Association.from_pairs(scene, pairs))


def judged(settings: VeracitySettings | None = None, **scene: object) -> dict[str, ShipVeracity]:
    veracity = AisVeracity(settings)
    for fix in fixes(**scene):  # type: ignore[arg-type]
        veracity.feed(fix)
    return {ship.mark: ship for ship in veracity.ships()}


@pytest.mark.parametrize("reference", ["relative", "true"])
def test_a_sighting_is_the_offset_itself_where_nothing_is_noisy(reference: str) -> None:
    """Ship 4 says 300 m too far north: radar sees it 300 m south of where it says, within 1 m."""
    fix = next(fixes({4: (300.0, 0.0)}, noise=0.0, reference=reference))
    seen = {s.mark.label: s for s in sightings(fix, ErrorModel())}
    assert seen["ship 4"].offset_m == pytest.approx([-300.0, 0.0], abs=1.0)
    assert np.hypot(*seen["ship 5"].offset_m) < 1.0
    assert seen["ship 4"].target == "04"


def test_a_mark_does_not_judge_itself() -> None:
    """With least squares a wrong mark pulls the fix; its own sighting is made without it."""
    scene = next(fixes({4: (300.0, 0.0)}, noise=0.0))
    assert scene.epoch is not None
    assert scene.association is not None
    pulled = adjust(scene.epoch, scene.association, kernel="none")
    seen = {s.mark.label: s for s in sightings(pulled, ErrorModel())}
    assert np.hypot(*PLANE.to_plane(pulled.position)) > 10.0  # type: ignore[arg-type]
    assert seen["ship 4"].offset_m == pytest.approx([-300.0, 0.0], abs=3.0)


def test_true_ships_agree() -> None:
    ships = judged(shift={})
    assert {ship.status for ship in ships.values()} == {"agrees"}
    assert all(ship.seen == 40 and ship.missing == 0 for ship in ships.values())
    assert min(ship.p_value or 0.0 for ship in ships.values()) > 0.01


def test_a_false_position_is_named_with_size_direction_and_significance() -> None:
    """Its AIS lies 400 m off towards 030: radar sees it 400 m towards 210, at a p-value below 1e-3 / 12 ships."""
    turn = math.radians(30.0)
    ships = judged(shift={4: (400.0 * math.cos(turn), 400.0 * math.sin(turn))})
    wrong = ships.pop("ship 4")
    assert wrong.status == "disagrees"
    assert wrong.offset_m == pytest.approx(400.0, abs=40.0)
    assert wrong.azimuth_deg == pytest.approx(210.0, abs=8.0)
    assert wrong.p_value is not None
    assert wrong.p_value < 1e-3 / 12
    assert {ship.status for ship in ships.values()} == {"agrees"}


def test_a_report_that_comes_late_is_said_to_be_late() -> None:
    wrong = judged(shift={}, late_s=60.0)["ship 3"]
    assert wrong.status == "disagrees"
    assert wrong.note.startswith("along its course: as if its reports were ")
    assert float(wrong.note.split()[8]) == pytest.approx(60.0, abs=8.0)
    assert wrong.note.endswith("s late")


def test_an_echo_that_goes_with_a_ship_elsewhere_is_found() -> None:
    """Ship 5 says 2 km too far east; its echo belongs to nobody and moves as the ship says it does."""
    ship = judged(shift={5: (0.0, 2000.0)}, unpaired=(5,))["ship 5"]
    assert ship.status == "elsewhere"
    assert ship.target == "05"
    assert ship.offset_m == pytest.approx(2000.0, abs=60.0)
    assert ship.azimuth_deg == pytest.approx(270.0, abs=2.0)
    assert ship.p_value is not None
    assert ship.p_value <= 0.1


def test_a_ship_seen_in_its_place_even_once_is_not_accused_of_being_elsewhere() -> None:
    veracity = AisVeracity()
    veracity.feed(next(fixes(shift={})))
    for fix in fixes(shift={5: (0.0, 2000.0)}, unpaired=(5,)):
        veracity.feed(fix)
    (ship,) = [ship for ship in veracity.ships() if ship.mark == "ship 5"]
    assert ship.seen == 1
    assert ship.status == "too_little"


def test_a_still_echo_near_a_ship_at_anchor_accuses_nobody() -> None:
    ship = judged(shift={5: (0.0, 2000.0)}, unpaired=(5,), velocity_mps=0.0)["ship 5"]
    assert ship.status != "elsewhere"


def test_a_large_ship_near_without_echo_is_named_where_the_others_have_theirs() -> None:
    everyone = VeracitySettings(near_share=1.0, beside_m=50.0)
    ship = judged(everyone, shift={}, without_echo=(5,), velocity_mps=0.0)["ship 5"]
    assert (ship.status, ship.seen, ship.missing) == ("no_echo", 0, ship.expected)
    assert ship.expected >= 30
    assert ship.p_value == pytest.approx(1.0 / (11 + 2))


def test_where_several_large_ships_have_no_echo_none_is_accused() -> None:
    """A radar that tracks a part of its echoes only."""
    everyone = VeracitySettings(near_share=1.0, beside_m=50.0)
    ships = judged(everyone, shift={}, without_echo=(4, 5, 8), velocity_mps=0.0)
    assert {ships[f"ship {k}"].status for k in (4, 5, 8)} == {"too_little"}
    assert ships["ship 5"].note == "no echo, like 23% of the 11 other large ships near"


def test_a_few_epochs_say_nothing() -> None:
    assert {s.status for s in judged(shift={4: (400.0, 0.0)}, epochs=4).values()} == {"too_little"}


def test_the_table_and_the_rows_say_the_same() -> None:
    ships = tuple(judged(shift={4: (400.0, 0.0)}, epochs=20).values())
    text = veracity_text(ships)
    assert "12 stations in radar range: 1 disagrees, 11 agrees" in text
    assert "ship 4" in text
    assert "ship 5" not in text
    assert "ship 5" in veracity_text(ships, all_ships=True)
    assert max(len(line) for line in veracity_text(ships, all_ships=True).splitlines()) <= 100
    content = json.loads(veracity_json(ships), parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    assert content["schema"] == SCHEMA
    assert content["ships"] == veracity_rows(ships)
    assert {row["mark"] for row in content["ships"]} == {ship.mark for ship in ships}
    assert veracity_text(()).startswith("AIS veracity: no station in radar range")
