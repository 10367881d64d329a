"""Cold start, no heading and no position: easy scenes are solved, scenes without an answer refused."""

import numpy as np
import pytest

import navfix
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.simulation.scenes import SceneRecipe, make_scene
from navfix.units import wrap_180

EASY = SceneRecipe(20, 40, 12.0, 16.0, clutter=0.1)


def check_all_solved(scenes: int) -> None:
    errors_m, turns_deg = [], []
    for seed in range(scenes):
        made = make_scene(EASY, seed)
        found = navfix.associate(made.epoch)
        errors_m.append(inverse(found.position, made.position)[0])
        turns_deg.append(abs(wrap_180(found.heading_deg - made.heading_deg)))
    assert max(turns_deg) < 2.0
    assert max(errors_m) < 300.0
    assert np.median(errors_m) < 30.0


def test_headings_all_round_are_all_solved():
    check_all_solved(250)


@pytest.mark.study
def test_a_thousand_headings_are_all_solved():
    check_all_solved(1000)


NOTHING_COMMON = [SceneRecipe(15, 60, clutter=1.0), SceneRecipe(40, 200, clutter=1.0)]


def check_refused(recipe: SceneRecipe, scenes: int) -> None:
    for seed in range(scenes):
        with pytest.raises(NoFix):
            navfix.associate(make_scene(recipe, seed).epoch)


@pytest.mark.parametrize("recipe", NOTHING_COMMON)
def test_scenes_without_a_common_target_are_refused(recipe: SceneRecipe):
    check_refused(recipe, 40)


@pytest.mark.study
@pytest.mark.parametrize("recipe", NOTHING_COMMON)
def test_study_scenes_without_a_common_target(recipe: SceneRecipe):
    check_refused(recipe, 500)
