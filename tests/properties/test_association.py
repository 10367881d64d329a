"""Turning or shifting what is seen turns or shifts the answer; a mirrored scene is refused."""

from dataclasses import replace

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import navfix
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.simulation.scenes import SceneRecipe, make_scene
from navfix.types import Position
from navfix.units import wrap_180

RECIPE = SceneRecipe(16, 40, 8.0, 12.0, clutter=0.2, false_ais=0.05)
SEEDS = st.integers(0, 10_000)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(seed=SEEDS, turn_deg=st.floats(0.0, 360.0))
def test_turning_the_ship_turns_the_heading_and_leaves_the_place(seed: int, turn_deg: float):
    made = make_scene(RECIPE, seed)
    turned = tuple(replace(t, bearing_deg=t.bearing_deg - turn_deg) for t in made.epoch.targets)
    one, other = navfix.associate(made.epoch), navfix.associate(replace(made.epoch, targets=turned))
    assert inverse(one.position, other.position)[0] < 5.0
    assert abs(wrap_180(other.heading_deg - one.heading_deg - turn_deg)) < 0.1


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=SEEDS, lat_deg=st.floats(-85.0, 85.0), lon_deg=st.floats(-180.0, 179.9))
def test_the_same_scene_elsewhere_on_earth_has_the_same_answer(seed: int, lat_deg: float, lon_deg: float):
    made = make_scene(replace(RECIPE, centre=Position(lat_deg, lon_deg)), seed)
    found = navfix.associate(made.epoch)
    assert inverse(found.position, made.position)[0] < 300.0
    assert abs(wrap_180(found.heading_deg - made.heading_deg)) < 2.0


@settings(max_examples=25, deadline=None)
@example(seed=139, layout="uniform")
@given(seed=st.integers(0, 10**9), layout=st.sampled_from(("uniform", "lanes", "anchorages")))
def test_a_mirrored_scene_is_refused(seed: int, layout: str):
    made = make_scene(replace(RECIPE, clutter=0.0, false_ais=0.0, layout=layout), seed)
    mirrored = tuple(replace(t, bearing_deg=-t.bearing_deg) for t in made.epoch.targets)
    with pytest.raises(NoFix):
        navfix.associate(replace(made.epoch, targets=mirrored))


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=SEEDS, random=st.randoms(use_true_random=False))
def test_the_order_of_points_changes_nothing(seed: int, random):
    made = make_scene(RECIPE, seed)
    targets, marks = list(made.epoch.targets), list(made.epoch.marks)
    random.shuffle(targets)
    random.shuffle(marks)
    one, other = navfix.associate(made.epoch), navfix.associate(replace(made.epoch, targets=targets, marks=marks))
    assert inverse(one.position, other.position)[0] < 5.0
