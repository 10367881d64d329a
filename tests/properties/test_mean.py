"""The plain-mean fix for any own ship, heading and marks: exact on exact data, blind to order."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from navfix.adjustment.mean import mean_fix
from navfix.geodesy import direct, inverse
from navfix.types import Association, Epoch, Mark, Position, RadarTarget

own_ships = st.builds(Position, st.floats(-80.0, 80.0), st.floats(-180.0, 180.0))
headings_deg = st.floats(0.0, 360.0, exclude_max=True)
polar_points = st.lists(
    st.tuples(st.floats(500.0, 22_000.0), st.integers(0, 359).map(float)),
    min_size=3,
    max_size=8,
    unique_by=lambda p: p[1],
)


def pictures(own: Position, heading_deg: float, polar: list[tuple[float, float]]) -> tuple[Epoch, Association]:
    targets = tuple(RadarTarget(f"T{n}", r, bearing - heading_deg) for n, (r, bearing) in enumerate(polar))
    marks = tuple(Mark(f"M{n}", direct(own, bearing, r), 10.0) for n, (r, bearing) in enumerate(polar))
    epoch = Epoch(None, targets, marks)
    return epoch, Association.from_pairs(epoch, [(n, n) for n in range(len(polar))])


@given(own_ships, headings_deg, polar_points)
def test_exact_data_give_own_ship_and_heading(
    own: Position, heading_deg: float, polar: list[tuple[float, float]]
) -> None:
    fix = mean_fix(*pictures(own, heading_deg, polar))
    assert fix.heading_deg is not None
    assert abs((fix.heading_deg - heading_deg + 180.0) % 360.0 - 180.0) < 1e-5
    assert inverse(fix.position, own)[0] < 2e-3


@given(own_ships, headings_deg, polar_points)
def test_the_order_of_the_pairs_does_not_matter(
    own: Position, heading_deg: float, polar: list[tuple[float, float]]
) -> None:
    epoch, association = pictures(own, heading_deg, polar)
    blurred = Epoch(
        None,
        tuple(
            RadarTarget(t.label, t.range_m * (1.0 + 0.01 * n), t.bearing_deg + n) for n, t in enumerate(epoch.targets)
        ),
        epoch.marks,
    )
    shuffled = Association.from_pairs(blurred, [tuple(pair) for pair in association.pairs[::-1].tolist()])
    one, other = mean_fix(blurred, association, reject=True), mean_fix(blurred, shuffled, reject=True)
    assert inverse(one.position, other.position)[0] < 1e-3
    assert np.array_equal(one.used, other.used[::-1])
