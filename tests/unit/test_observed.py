"""What goes in is checked: a number that is none is refused where it enters, not where it would be used."""

from __future__ import annotations

import math

import pytest

from navfix.errors import InputError
from navfix.types import Mark, Position, RadarTarget


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("name", ["speed_mps", "course_deg", "heading_deg", "age_s"])
def test_what_is_not_known_of_a_mark_is_none_and_not_nan(name: str, value: float):
    with pytest.raises(InputError, match=f"mark A: {name} must be finite, or None if unknown"):
        Mark("A", Position(54.0, 12.0), 10.0, **{name: value})


@pytest.mark.parametrize("name", ["speed_mps", "course_deg"])
def test_what_is_not_known_of_a_target_is_none_and_not_nan(name: str):
    with pytest.raises(InputError, match=f"target 07: {name} must be finite, or None if unknown"):
        RadarTarget("07", 900.0, 10.0, **{name: math.nan})
