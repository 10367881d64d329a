"""From scan to scan: an index of mark pairs that is kept, and a warm start that is checked."""

from dataclasses import replace

import numpy as np
import pytest

import navfix
from navfix.association import KeptIndex, seeds
from navfix.association import scene as scenes
from navfix.association.pair_index import PairIndex
from navfix.catalog import association_model, radar_model
from navfix.errors import NoFix
from navfix.geodesy import direct, inverse
from navfix.simulation.scenes import SceneRecipe, make_scene
from navfix.types import HeadingHint, Mark, PositionHint
from navfix.units import wrap_180

BUSY = SceneRecipe(30, 120, 12.0, 20.0, clutter=0.25, false_ais=0.1)
MODEL, RADAR = association_model(), radar_model("imo")


def moved(mark: Mark, azimuth_deg: float, metres: float) -> Mark:
    return replace(mark, position=direct(mark.position, azimuth_deg, metres))


def votes(scene: scenes.Scene, index: PairIndex) -> set[tuple[int, int, int]]:
    """Return the votes of the first radar pairs of the exact index, rounded: place and heading."""
    exact = PairIndex.of(scene.z, 2.0 * scene.radar_range_m)
    voting = seeds.radar_pairs(scene, exact, MODEL).take(slice(0, 60))
    p, heading_rad = seeds.votes(scene, index, voting, replace(MODEL, votes_at_most=10**7))
    return {
        (round(n), round(e), round(h))
        for n, e, h in zip(p.real.tolist(), p.imag.tolist(), np.degrees(heading_rad).tolist(), strict=True)
    }


def test_a_kept_index_finds_the_pairs_of_an_index_built_anew():
    made, kept = make_scene(BUSY, 1), KeptIndex()
    random = np.random.default_rng(3)
    kept.of(scenes.build(made.epoch, RADAR, MODEL), made.epoch.marks)
    marks = [moved(m, 360.0 * random.uniform(), 50.0 * random.uniform()) for m in made.epoch.marks]
    marks[3] = moved(marks[3], 45.0, 2000.0)  # too far for the tolerance
    del marks[40]
    marks += [replace(marks[0], label="new", mmsi=999, position=direct(made.position, 10.0, 3000.0))]
    random.shuffle(marks)
    scene = scenes.build(replace(made.epoch, marks=tuple(marks)), RADAR, MODEL)
    index = kept.of(scene, tuple(marks))
    assert (kept.built, kept.kept) == (1, 1)
    exact = votes(scene, PairIndex.of(scene.z, 2.0 * scene.radar_range_m))
    assert len(exact) > 500
    assert len(votes(scene, index) ^ exact) < 0.01 * len(exact)  # float32 distances at the edge of a gate


def test_a_kept_index_is_built_anew_when_the_picture_has_changed():
    kept = KeptIndex()
    for seed in (1, 2):
        made = make_scene(BUSY, seed)
        elsewhere = tuple(replace(m, label=f"{seed} {m.label}") for m in made.epoch.marks)
        kept.of(scenes.build(made.epoch, RADAR, MODEL), elsewhere)
    assert (kept.built, kept.kept) == (2, 0)


def test_answers_are_the_same_with_a_kept_index_while_ships_move():
    made, kept = make_scene(BUSY, 5), KeptIndex()
    random = np.random.default_rng(0)
    courses = 360.0 * random.uniform(size=len(made.epoch.marks))
    for metres in (0.0, 20.0, 40.0, 55.0):
        marks = tuple(moved(m, c, metres) for m, c in zip(made.epoch.marks, courses, strict=True))
        epoch = replace(made.epoch, marks=marks)
        one, other = navfix.associate(epoch), navfix.associate(epoch, index=kept)
        assert inverse(one.position, other.position)[0] < 5.0
        assert {tuple(p) for p in one.pairs} == {tuple(p) for p in other.pairs}
    assert (kept.built, kept.kept) == (1, 3)


def hinted(made, off_m: float, off_deg: float):
    return replace(
        made.epoch,
        position_hint=PositionHint(direct(made.position, 70.0, off_m), 500.0),
        heading_hint=HeadingHint(made.heading_deg + off_deg, 3.0),
    )


def test_a_warm_start_gives_the_place_of_a_full_search():
    warm = 0
    for seed in range(20):
        made = make_scene(BUSY, seed)
        epoch = hinted(made, 400.0, 2.0)
        quick, full = navfix.associate(epoch, warm=True), navfix.associate(epoch)
        warm += any("Warm start" in note for note in quick.notes)
        assert inverse(quick.position, full.position)[0] < 20.0
        assert abs(wrap_180(quick.heading_deg - full.heading_deg)) < 0.2
    assert warm >= 18


@pytest.mark.parametrize(("off_m", "off_deg"), [(30_000.0, 0.0), (0.0, 90.0), (8_000.0, 30.0)])
def test_a_warm_start_from_a_wrong_hint_falls_back_to_the_whole_search(off_m: float, off_deg: float):
    for seed in range(5):
        made = make_scene(BUSY, seed)
        found = navfix.associate(hinted(made, off_m, off_deg), warm=True)
        assert inverse(found.position, made.position)[0] < 300.0
        assert any("refuted" in note for note in found.notes)


def test_a_warm_start_where_nothing_is_right_answers_nothing():
    for seed in range(10):
        made = make_scene(replace(BUSY, clutter=1.0), seed)
        with pytest.raises(NoFix):
            navfix.associate(hinted(made, 200.0, 1.0), warm=True)
