"""Lever arms and alignment, by simulation: the position is the reference point's, the heading the bow's."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix.adjustment import adjust
from navfix.adjustment.lever_arm import Alignment, gnss_at_reference_point
from navfix.catalog import radar_model
from navfix.errors import InputError
from navfix.geodesy import LocalPlane, inverse
from navfix.types import Association, Epoch, GnssReport, HeadingHint, Position, confidence_radius
from tests.adjustment_scenes import GDYNIA_BAY as OWN
from tests.adjustment_scenes import epoch_scene

ANTENNA_M, ZERO_MARK_DEG, HEADING_DEG = (-120.0, 8.0), 3.0, 200.0


def antenna_place(own: Position, heading_deg: float, offset_m: tuple[float, float]) -> Position:
    """Written out from the ship's axes: forward along the heading, starboard 90 deg to its right."""
    forward, starboard, h = *offset_m, math.radians(heading_deg)
    north = forward * math.cos(h) + starboard * math.cos(h + math.pi / 2.0)
    east = forward * math.sin(h) + starboard * math.sin(h + math.pi / 2.0)
    return LocalPlane(own).to_position(north, east)


def mounted_scene(seed: int, **scene: object) -> tuple[Epoch, Association]:
    """What a radar 120 m aft, 8 m to starboard, its zero mark 3 deg to starboard of the bow, sees."""
    antenna = antenna_place(OWN, HEADING_DEG, ANTENNA_M)
    rng = np.random.default_rng(seed)
    return epoch_scene(rng, antenna, heading_deg=HEADING_DEG + ZERO_MARK_DEG, **scene)  # type: ignore[arg-type]


def test_exact_observations_give_reference_point_and_bow() -> None:
    epoch, association = mounted_scene(1, noise=0.0, marks=6)
    fix = adjust(epoch, association, radar_antenna_m=ANTENNA_M, alignment=(ZERO_MARK_DEG, 0.2))
    assert inverse(OWN, fix.position)[0] < 1e-2
    assert fix.heading_deg == pytest.approx(HEADING_DEG, abs=1e-3)
    assert fix.heading_reference == "bow"
    plain = adjust(epoch, association)
    assert inverse(OWN, plain.position)[0] == pytest.approx(math.hypot(*ANTENNA_M), abs=0.02)
    assert plain.heading_reference == "radar_zero_mark"


def test_the_radar_model_can_carry_its_mounting() -> None:
    epoch, association = mounted_scene(2, marks=6)
    model = replace(
        radar_model("imo"),
        antenna_forward_m=ANTENNA_M[0], antenna_starboard_m=ANTENNA_M[1],
        alignment_deg=ZERO_MARK_DEG, alignment_sigma_deg=0.2,
    )  # fmt: skip
    one = adjust(epoch, association, radar=model)
    other = adjust(epoch, association, radar_antenna_m=ANTENNA_M, alignment=Alignment(ZERO_MARK_DEG, 0.2))
    assert inverse(one.position, other.position)[0] == 0.0
    np.testing.assert_array_equal(one.covariance, other.covariance)


def test_the_alignment_adds_its_variance_to_the_heading_and_little_to_the_position() -> None:
    epoch, association = mounted_scene(3)
    plain = adjust(epoch, association)
    fix = adjust(epoch, association, radar_antenna_m=ANTENNA_M, alignment=(ZERO_MARK_DEG, 0.5))
    assert fix.covariance[2, 2] == pytest.approx(plain.covariance[2, 2] + math.radians(0.5) ** 2)
    np.testing.assert_allclose(fix.covariance, fix.sigma0**2 * fix.cofactor_matrix)
    swing_m = math.hypot(*ANTENNA_M) * math.radians(0.5)
    assert np.trace(fix.covariance[:2, :2]) < np.trace(plain.covariance[:2, :2]) + 2.0 * swing_m**2


def test_the_ellipse_of_the_reference_point_holds() -> None:
    """200 runs with marks in a sector, the alignment drawn from its sigma: 95 % within the 3 x 3 covariance's part."""
    inside, heading_inside = 0, 0
    rng = np.random.default_rng(4)
    for seed in range(200):
        epoch, association = mounted_scene(1000 + seed, marks=8, sector_deg=40.0)
        told = (ZERO_MARK_DEG + 1.0 * rng.normal(), 1.0)
        fix = adjust(epoch, association, radar_antenna_m=ANTENNA_M, alignment=told, kernel="none", solver="dense")
        offset = LocalPlane(fix.position).to_plane(OWN)  # type: ignore[arg-type]
        distance = math.sqrt(offset @ np.linalg.solve(fix.covariance[:2, :2], offset))
        inside += distance < confidence_radius(0.95, dof=fix.dof)
        off_rad = math.radians((fix.heading_deg or 0.0) - HEADING_DEG)
        heading_inside += abs(off_rad) < 2.2 * math.sqrt(fix.covariance[2, 2])
    assert 180 <= inside <= 199
    assert 180 <= heading_inside <= 199


def test_other_places_are_the_reference_points_too() -> None:
    epoch, association = mounted_scene(5, marks=6, noise=0.0)
    start = (antenna_place(OWN, 20.0, (30.0, 0.0)), HEADING_DEG)
    fix = adjust(epoch, association, radar_antenna_m=ANTENNA_M, alignment=(ZERO_MARK_DEG, 0.0), start=start)
    assert inverse(OWN, fix.position)[0] < 1e-2


def test_true_bearings_need_a_hint_for_the_lever_arm() -> None:
    epoch, association = mounted_scene(6, bearing_reference="true", noise=0.0)
    without = adjust(epoch, association, radar_antenna_m=ANTENNA_M)
    assert inverse(OWN, without.position)[0] == pytest.approx(math.hypot(*ANTENNA_M), abs=0.5)
    assert any("no heading turns its offset" in note for note in without.notes)
    hinted = replace(epoch, heading_hint=HeadingHint(HEADING_DEG, 1.0))
    assert inverse(OWN, adjust(hinted, association, radar_antenna_m=ANTENNA_M).position)[0] < 0.5


def test_own_gnss_is_carried_to_the_reference_point() -> None:
    epoch, association = epoch_scene(np.random.default_rng(7), heading_deg=HEADING_DEG)
    fix = adjust(epoch, association)
    gnss = GnssReport(antenna_place(OWN, HEADING_DEG, (90.0, -5.0)), 3.0)
    moved = gnss_at_reference_point(gnss, (90.0, -5.0), fix)
    assert inverse(OWN, moved.position)[0] < 1.0
    assert 3.0 < moved.sigma_m < 3.5
    true_epoch, pairs = epoch_scene(np.random.default_rng(8), bearing_reference="true")
    unturned = gnss_at_reference_point(gnss, (90.0, -5.0), adjust(true_epoch, pairs))
    assert unturned.sigma_m > 90.0


def test_impossible_offsets_are_refused() -> None:
    epoch, association = mounted_scene(9, marks=4)
    with pytest.raises(InputError, match="radar_antenna_m"):
        adjust(epoch, association, radar_antenna_m=(math.nan, 0.0))
    with pytest.raises(InputError, match="alignment"):
        adjust(epoch, association, alignment=(1.0, -1.0))
