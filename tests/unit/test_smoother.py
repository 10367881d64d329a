"""The smoother: better than the fixes it is given, honest, not led astray by gaps, restarts and wrong fixes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest

from navfix.adjustment import adjust
from navfix.catalog import own_motion_model
from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.report.answer import Answer
from navfix.sequence.answers import reckoned, smoothed
from navfix.sequence.chain import consistent
from navfix.sequence.dead_reckoning import DeadReckoner
from navfix.sequence.smoother import smooth
from navfix.types import Association, Epoch, Fix, GnssReport, Position
from tests.window_scenes import Errors, Passage, passage

IMO_LIKE = Errors(bearing_deg=1.0)


@pytest.fixture(scope="module")
def sailed() -> Passage:
    return passage(np.random.default_rng(1), epochs=40, step_s=5.0, targets=10, errors=IMO_LIKE, mates=0.3)


@pytest.fixture(scope="module")
def alone(sailed: Passage) -> tuple[Fix, ...]:
    return tuple(fix_of(epoch, sailed) for epoch in sailed.epochs)


def fix_of(epoch: Epoch, sailed: Passage) -> Fix:
    return adjust(epoch, Association.from_pairs(epoch, list(sailed.pairs.items())))


def errors_of(sailed: Passage, fixes: Sequence[Fix | None]) -> np.ndarray:
    return np.array([np.hypot(*sailed.error(f.position, i)) for i, f in enumerate(fixes) if f is not None])


def test_every_epoch_is_better_known_from_both_sides(sailed: Passage, alone: tuple[Fix, ...]) -> None:
    found = smooth(sailed.epochs, alone)
    assert all(fix is not None for fix in found)
    before, after = errors_of(sailed, alone), errors_of(sailed, found)
    assert np.sqrt(np.mean(after**2)) < 0.75 * np.sqrt(np.mean(before**2))
    first = found[0]
    assert first is not None
    assert first.start == "smoother"
    assert first.epoch is sailed.epochs[0]
    assert {o.target for o in first.observations} == set(sailed.pairs)


def test_scans_without_a_fix_are_given_one_and_far_ones_none(sailed: Passage, alone: tuple[Fix, ...]) -> None:
    sparse = [fix if i % 6 == 0 and i < 12 else None for i, fix in enumerate(alone)]
    found = smooth(sailed.epochs, sparse)
    there = [fix is not None for fix in found]
    assert all(there[:30])
    assert not any(there[31:]), "30 s is the last fix; 120 s later nothing is said any more"
    assert errors_of(sailed, found[:7]).max() < 120.0


def test_a_wrong_fix_far_away_is_left_out(sailed: Passage, alone: tuple[Fix, ...]) -> None:
    crossed = {f"t{i}": f"m{(i + 1) % 10}" for i in range(10)}
    epoch = sailed.epochs[15]
    far = LocalPlane(Position(54.5, 18.8)).to_position(8000.0, -5000.0)
    wrong = replace(alone[15], position=far, association=Association.from_pairs(epoch, list(crossed.items())))
    given = [*alone[:15], wrong, *alone[16:]]
    time_s = np.array([e.time_utc.timestamp() for e in sailed.epochs if e.time_utc])
    assert consistent(given, time_s, own_motion_model()) == [i for i in range(40) if i != 15]
    assert errors_of(sailed, smooth(sailed.epochs, given)).max() < 1.5 * errors_of(sailed, alone).max()


def test_fixes_that_contradict_each_other_are_not_smoothed(sailed: Passage, alone: tuple[Fix, ...]) -> None:
    far = LocalPlane(Position(54.5, 18.8)).to_position(8000.0, 0.0)
    given = [replace(fix, position=far) if i % 2 else fix for i, fix in enumerate(alone)]
    assert all(fix is None for fix in smooth(sailed.epochs, given))


def test_a_clock_set_back_begins_another_passage(sailed: Passage, alone: tuple[Fix, ...]) -> None:
    again = [replace(e, time_utc=e.time_utc - timedelta(seconds=60.0)) for e in sailed.epochs[10:20] if e.time_utc]
    found = smooth([*sailed.epochs[:10], *again], alone[:20])
    assert all(fix is not None for fix in found)


def test_a_long_log_is_cut_into_chunks_and_every_epoch_answered_once() -> None:
    long = passage(np.random.default_rng(2), epochs=45, step_s=20.0, targets=6, speed_mps=4.0, errors=IMO_LIKE)
    fixes = [fix_of(epoch, long) for epoch in long.epochs]
    found = smooth(long.epochs, fixes)
    assert all(fix is not None and fix.epoch is epoch for fix, epoch in zip(found, long.epochs, strict=True))


def test_nothing_in_nothing_out() -> None:
    assert smooth([], []) == ()
    one = passage(np.random.default_rng(3), epochs=2, targets=4)
    assert smooth(one.epochs, [None, None]) == (None, None)
    with pytest.raises(InputError, match="2 epochs need as many fixes"):
        smooth(one.epochs, [None])


def test_answers_carry_the_smoothed_fix_a_verdict_and_the_reckoned_position(
    sailed: Passage, alone: tuple[Fix, ...]
) -> None:
    reckoner, answers = DeadReckoner(), []
    for epoch, fix in zip(sailed.epochs[:20], alone, strict=False):
        north_m, east_m, _ = sailed.truth[len(answers)].tolist()
        seen = replace(epoch, gnss=GnssReport(sailed.plane.to_position(north_m, east_m), 10.0))
        answers.append(reckoned(Answer(seen, fix=replace(fix, epoch=seen)), reckoner))
    found = smoothed(answers)
    assert answers[0].dead_reckoning is None
    for answer in found[1:]:
        assert answer.fix is not None
        assert answer.gnss is not None
        assert answer.gnss.verdict != "unsafe"
        assert answer.dead_reckoning is not None
        assert answer.fix.position != answer.dead_reckoning.position
