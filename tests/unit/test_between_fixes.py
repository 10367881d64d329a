"""Dead reckoning beside the navigator: none before a fix, none after a conflict, kept where echoes are only lost."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from navfix.geodesy import LocalPlane, inverse
from navfix.sequence.between_fixes import BetweenFixes
from navfix.sequence.track import Track
from navfix.types import Association, Fix
from tests.reckoning_scenes import OWN, epoch_at, fix_at


def track(**state: Any) -> Track:
    return cast(
        Track,
        SimpleNamespace(
            lost=state.get("lost", False),
            lapsed=state.get("lapsed", False),
            standing=SimpleNamespace(
                outdone=state.get("outdone", False), why_silent=lambda now_s: state.get("silent", "")
            ),
        ),
    )


def stated(fix: Fix, probability: float) -> Fix:
    found = Association(np.zeros((0, 2), np.int64), np.zeros(0), probability_wrong=probability)
    return replace(fix, association=found)


def fixed(held: Track) -> BetweenFixes:
    """Return the dead reckoning of a place that had a fix every 3 s for a minute."""
    between = BetweenFixes()
    for k in range(21):
        between.carry(epoch_at(3.0 * k))
        between.answer(held, 63.0, conflict=False, seen=True)
        between.take(epoch_at(3.0 * k), stated(fix_at(OWN), 0.02))
    between.carry(epoch_at(63.0))
    return between


def test_nothing_is_reckoned_before_the_first_fix():
    between = BetweenFixes()
    between.carry(epoch_at(0.0))
    assert between.answer(None, 63.0, conflict=False, seen=True) is None
    between.carry(epoch_at(3.0))
    assert between.answer(track(), 63.0, conflict=False, seen=True) is None


def test_it_says_how_sure_the_last_fix_was():
    held = track()
    found = fixed(held).answer(held, 63.0, conflict=False, seen=True)
    assert found is not None
    assert found.probability_wrong == pytest.approx(0.02)
    assert found.doubt == ""


def test_a_conflict_ends_it_for_good():
    held = track()
    between = fixed(held)
    assert between.answer(None, 63.0, conflict=True, seen=True) is None
    between.carry(epoch_at(66.0))
    assert between.answer(None, 63.0, conflict=False, seen=True) is None


def test_a_place_that_is_given_up_takes_it_along_and_one_that_is_lost_or_unseen_does_not():
    held = track()
    assert fixed(held).answer(None, 63.0, conflict=False, seen=True) is None
    assert fixed(held).answer(None, 63.0, conflict=False, seen=False) is not None
    lost = track(lost=True)
    assert fixed(lost).answer(None, 63.0, conflict=False, seen=True) is not None


def test_a_lapsed_place_is_reckoned_with_doubt_and_one_that_a_rival_overtakes_not_at_all():
    held = track()
    between = fixed(held)
    held.lapsed = True
    found = between.answer(held, 63.0, conflict=False, seen=True)
    assert found is not None
    assert found.doubt
    held.standing.outdone = True
    assert between.answer(held, 63.0, conflict=False, seen=True) is None


def test_a_place_that_was_not_found_for_long_is_reckoned_with_that_doubt_where_echoes_speak():
    held = track(silent="lapsed: no solve has found it")
    seen, unseen = (fixed(held).answer(held, 63.0, conflict=False, seen=there) for there in (True, False))
    assert seen is not None
    assert unseen is not None
    assert seen.doubt == "lapsed: no solve has found it"
    assert unseen.doubt == "", "without echoes no new place is held by mistake"


def test_the_fix_of_another_place_begins_anew_at_once():
    lost = track(lost=True)
    between = fixed(lost)
    far = LocalPlane(OWN).to_position(5000.0, 0.0)
    between.answer(track(), 63.0, conflict=False, seen=True)
    between.take(epoch_at(63.0), fix_at(far))
    between.carry(epoch_at(66.0))
    found = between.answer(track(lost=True), 63.0, conflict=False, seen=False)
    assert found is not None
    assert inverse(found.position, far)[0] < 100.0
