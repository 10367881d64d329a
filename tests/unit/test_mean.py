"""The plain-mean fix: back-projection, mean, weights, rejection, ellipses; hand-checkable cases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from navfix.adjustment.mean import factor_ellipses, heading_of_pairs, mean_fix, outlying, probability_of_factor
from navfix.errors import InputError, TooFewPairs, Unobservable
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.types import Association, Epoch, HeadingHint, Mark, Position, RadarTarget

NM_12_M = 12 * 1852.0


def scene(
    own: Position,
    polar: Sequence[tuple[float, float]],
    *,
    heading_deg: float = 0.0,
    reference: str = "relative",
    kinds: Sequence[str] | None = None,
    offsets_ne_m: Sequence[tuple[float, float]] | None = None,
    hint: HeadingHint | None = None,
) -> tuple[Epoch, Association]:
    """Return exact targets at (range m, true bearing deg) from own ship, and marks shifted by ``offsets_ne_m``."""
    targets, marks = [], []
    for index, (range_m, bearing_deg) in enumerate(polar):
        seen_deg = bearing_deg - heading_deg if reference == "relative" else bearing_deg
        targets.append(RadarTarget(f"T{index}", range_m, seen_deg, reference))  # type: ignore[arg-type]
        place = direct(own, bearing_deg, range_m)
        if offsets_ne_m is not None:
            place = LocalPlane(place).to_position(*offsets_ne_m[index])
        marks.append(Mark(f"M{index}", place, 10.0, kinds[index] if kinds else "ship"))  # type: ignore[arg-type]
    epoch = Epoch(None, tuple(targets), tuple(marks), heading_hint=hint)
    return epoch, Association.from_pairs(epoch, [(index, index) for index in range(len(polar))])


RING = [(NM_12_M, azimuth) for azimuth in range(0, 360, 10)]
FEW = [(3000.0, 20.0), (5000.0, 110.0), (8000.0, 250.0)]


@pytest.mark.parametrize(
    "own", [Position(0.0, 0.0), Position(70.0, 20.0), Position(-60.0, 179.99), Position(89.0, 0.0)]
)
def test_exact_data_give_own_ship_within_a_millimetre(own: Position) -> None:
    epoch, association = scene(own, RING, heading_deg=77.0)
    fix = mean_fix(epoch, association, heading_deg=77.0)
    assert inverse(fix.position, own)[0] < 1e-3
    assert np.abs(fix.individual_ne_m).max() < 1e-3


@pytest.mark.parametrize("own", [Position(0.0, 0.0), Position(70.0, 20.0), Position(-60.0, 179.99)])
@pytest.mark.parametrize("heading_deg", [0.0, 123.4, 359.9])
def test_the_heading_is_found_from_the_pairs(own: Position, heading_deg: float) -> None:
    epoch, association = scene(own, FEW, heading_deg=heading_deg)
    fix = mean_fix(epoch, association)
    assert fix.heading_deg is not None
    assert (fix.heading_deg - heading_deg + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1e-6)
    assert inverse(fix.position, own)[0] < 1e-3


def test_true_bearing_is_relative_plus_heading() -> None:
    """Heading east, mark dead ahead: the mark is east of own ship (a minus would put it west)."""
    own = Position(54.0, 10.0)
    mark = Mark("M", direct(own, 90.0, 2000.0), 10.0)
    epoch = Epoch(None, (RadarTarget("T", 2000.0, 0.0),), (mark,))
    fix = mean_fix(epoch, Association.from_pairs(epoch, [(0, 0)]), heading_deg=90.0)
    assert inverse(fix.position, own)[0] < 1e-3


@pytest.mark.parametrize(("lat_deg", "miss_m"), [(60.0, 134.0), (70.0, 212.0)])
def test_the_literal_version_misses_a_mark_due_east(lat_deg: float, miss_m: float) -> None:
    own = Position(lat_deg, 5.0)
    epoch, association = scene(own, [(NM_12_M, 90.0)], reference="true")
    assert inverse(mean_fix(epoch, association, literal=True).position, own)[0] == pytest.approx(miss_m, abs=0.5)
    assert inverse(mean_fix(epoch, association).position, own)[0] < 1e-3


def test_the_literal_version_of_a_full_ring_is_too_far_towards_the_equator() -> None:
    own = Position(60.0, 5.0)
    epoch, association = scene(own, RING, reference="true")
    south_m, east_m = LocalPlane(own).to_plane(mean_fix(epoch, association, literal=True).position) * (-1.0, 1.0)
    assert south_m == pytest.approx(67.0, abs=0.5)
    assert east_m == pytest.approx(0.0, abs=0.1)


def test_true_bearings_need_no_heading_and_tell_none() -> None:
    own = Position(54.0, 10.0)
    fix = mean_fix(*scene(own, FEW, reference="true"))
    assert fix.heading_deg is None
    assert inverse(fix.position, own)[0] < 1e-3


def test_true_bearings_help_to_find_the_heading_of_one_relative_bearing() -> None:
    own = Position(54.0, 10.0)
    epoch, association = scene(own, FEW, reference="true")
    bow = RadarTarget("T0", FEW[0][0], FEW[0][1] - 33.0)
    mixed = Epoch(None, (bow, *epoch.targets[1:]), epoch.marks)
    assert mean_fix(mixed, association).heading_deg == pytest.approx(33.0, abs=1e-6)


def test_the_headings_order_is_argument_then_association_then_hint() -> None:
    own = Position(54.0, 10.0)
    epoch, by_hand = scene(own, FEW, heading_deg=30.0, hint=HeadingHint(31.0, 1.0))
    posed = Association(by_hand.pairs, by_hand.probability, position=own, heading_deg=32.0)
    assert mean_fix(epoch, by_hand).heading_deg == 31.0
    assert mean_fix(epoch, posed).heading_deg == 32.0
    assert mean_fix(epoch, posed, heading_deg=393.0).heading_deg == 33.0


def test_the_mean_across_180_east_stays_there() -> None:
    own = Position(10.0, 180.0)
    shifts = [(0.0, 300.0), (0.0, -300.0), (90.0, 0.0)]
    fix = mean_fix(*scene(own, FEW, reference="true", offsets_ne_m=shifts))
    assert LocalPlane(own).to_plane(fix.position) == pytest.approx([30.0, 0.0], abs=0.5)


@pytest.mark.parametrize(
    "weights", [{"aton": 3.0}, {"ship": 1.0, "aton": 3.0, "charted": 9.0}, [1.0, 1.0, 3.0], np.array([2, 2, 6])]
)
def test_weights_by_kind_or_by_hand_draw_the_mean(weights: object) -> None:
    """Two ships right, one aid to navigation 100 m north: weight 3 of 5 gives 60 m."""
    own = Position(0.0, 10.0)
    epoch, association = scene(
        own, FEW, reference="true", kinds=("ship", "ship", "aton"), offsets_ne_m=[(0, 0), (0, 0), (100, 0)]
    )
    fix = mean_fix(epoch, association, weights=weights)  # type: ignore[arg-type]
    assert LocalPlane(own).to_plane(fix.position) == pytest.approx([60.0, 0.0], abs=1e-3)


def test_a_pair_of_weight_zero_takes_no_part() -> None:
    own = Position(0.0, 10.0)
    epoch, association = scene(own, FEW, reference="true", offsets_ne_m=[(0, 0), (0, 0), (900, 0)])
    fix = mean_fix(epoch, association, weights=[1, 1, 0])
    assert fix.used.tolist() == [True, True, False]
    assert inverse(fix.position, own)[0] < 1e-3
    assert fix.covariance is None


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ({"buoy": 1.0}, "unknown kind 'buoy'"),
        ([1.0, 2.0], "one for each of the 3 pairs"),
        ([1.0, -1.0, 1.0], "must be finite, >= 0"),
        ([0.0, 0.0, 0.0], "not all zero"),
        ([1.0, math.nan, 1.0], "must be finite"),
    ],
)
def test_weights_that_cannot_be_right_are_refused(weights: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        mean_fix(*scene(Position(0.0, 0.0), FEW), weights=weights)  # type: ignore[arg-type]


SCATTER = [(10.0, 5.0), (-12.0, 3.0), (4.0, -9.0), (-3.0, 8.0), (7.0, -6.0), (-6.0, -4.0)]
SIX = [(4000.0, azimuth) for azimuth in range(0, 360, 60)]


def test_one_wrong_place_of_six_is_rejected() -> None:
    own = Position(54.0, 10.0)
    shifts = [*SCATTER[:5], (800.0, -300.0)]
    epoch, association = scene(own, SIX, reference="true", offsets_ne_m=shifts)
    kept, rejected = mean_fix(epoch, association), mean_fix(epoch, association, reject=True)
    assert kept.used.all()
    assert rejected.used.tolist() == [True] * 5 + [False]
    assert inverse(rejected.position, own)[0] < 5.0 < 100.0 < inverse(kept.position, own)[0]


def test_fewer_than_five_places_reject_nothing() -> None:
    places = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1000.0, 1000.0)])
    assert not outlying(places).any()
    assert outlying(np.vstack([places, [(1.0, 1.0)]])).tolist() == [False, False, False, True, False]


def test_places_on_one_line_reject_nothing() -> None:
    """Without the last place the others lie on a line: their covariance has no inverse."""
    line = np.array([(float(n), 2.0 * n) for n in range(6)] + [(0.0, 50.0)])
    assert not outlying(line)[-1]


def test_the_rejection_distance_is_that_of_the_others_alone() -> None:
    """The four arms of a cross of length 1 have the covariance 2/3 in each axis: distance d lies at d sqrt(2/3)."""
    cross = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
    for distance, expected in ((2.99, False), (3.01, True)):
        places = np.vstack([cross, [(distance * math.sqrt(2.0 / 3.0), 0.0)]])
        assert bool(outlying(places)[-1]) is expected


def test_the_spread_is_the_covariance_of_the_single_places() -> None:
    own = Position(0.0, 10.0)
    fix = mean_fix(*scene(own, SIX, reference="true", offsets_ne_m=SCATTER))
    assert fix.covariance is not None
    assert fix.covariance == pytest.approx(np.cov(np.array(SCATTER), rowvar=False), rel=1e-3)


def test_ellipses_at_factors_1_to_4_scale_with_the_factor() -> None:
    fix = mean_fix(*scene(Position(0.0, 10.0), SIX, reference="true", offsets_ne_m=SCATTER))
    assert fix.covariance is not None
    ellipses = factor_ellipses(fix)
    one_sigma = math.sqrt(np.linalg.eigvalsh(fix.covariance)[1])
    assert [ellipse.semi_major_m / one_sigma for ellipse in ellipses] == pytest.approx([1.0, 2.0, 3.0, 4.0])
    assert [ellipse.probability for ellipse in ellipses] == pytest.approx([0.3935, 0.8647, 0.9889, 0.99966], abs=1e-4)


def test_two_places_have_no_spread() -> None:
    fix = mean_fix(*scene(Position(0.0, 10.0), FEW[:2], reference="true"))
    assert fix.ellipse() is None
    with pytest.raises(TooFewPairs, match="at least 3 places, got 2"):
        factor_ellipses(fix)


@pytest.mark.parametrize("factor", [0.0, -1.0, 9.0, math.nan])
def test_a_factor_that_cannot_be_right_is_refused(factor: float) -> None:
    with pytest.raises(InputError, match=r"within 0 \.\. 8"):
        probability_of_factor(factor)


def test_no_pairs_give_no_mean() -> None:
    epoch, _ = scene(Position(0.0, 0.0), FEW)
    with pytest.raises(TooFewPairs, match="at least one pair"):
        mean_fix(epoch, Association.from_pairs(epoch, []))


def test_one_relative_bearing_without_a_heading_gives_no_mean() -> None:
    with pytest.raises(TooFewPairs, match="at least 2"):
        mean_fix(*scene(Position(0.0, 0.0), FEW[:1]))


@pytest.mark.parametrize("collapse", [lambda e: e.targets[:1] * 3, None], ids=["targets", "marks"])
def test_targets_or_marks_in_one_point_give_no_heading(
    collapse: Callable[[Epoch], tuple[RadarTarget, ...]] | None,
) -> None:
    epoch, _ = scene(Position(50.0, 0.0), FEW)
    targets = collapse(epoch) if collapse else epoch.targets
    marks = epoch.marks if collapse else epoch.marks[:1] * 3
    with pytest.raises(Unobservable, match="one point"):
        heading_of_pairs(list(zip(targets, marks, strict=True)))
