"""The method from one end to the other: log -> epochs -> association -> adjustment -> answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from functools import partial

from navfix.adjustment.visible_side import adjust_visible_side
from navfix.answering import Method, answer, beside, watched
from navfix.association import associate
from navfix.association.window.associate import solve_jointly
from navfix.association.window.tracks import since_silence
from navfix.catalog import CpdModel, RadarModel, association_method
from navfix.errors import InputError, NoFix
from navfix.integrity import with_integrity, with_window_integrity
from navfix.kernels import Kernel
from navfix.nmea import Log
from navfix.picture import epochs as _epochs
from navfix.refinement import refined
from navfix.report.answer import Answer
from navfix.report.timing import StepClock
from navfix.target_list import listed
from navfix.types import Association, Epoch, Fix, Mark, Pairing, TargetList

__all__ = ["answer", "answer_of_window", "beside", "epochs", "fix", "targets", "watched"]


def fix(
    epoch: Epoch | Sequence[Epoch],
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    method: Method = "seeded",
) -> Fix:
    """Find own position and heading from one epoch, with no idea of either beforehand.

    Parameters
    ----------
    epoch : targets and marks at one instant; or a sequence of epochs in the order of time, a window that is solved
        together: the fix is that of its newest epoch
    radar : sigma of one range [m] and one bearing [deg], where the targets bring none
    kernel : damping function of the adjustment, on the standardised residual (no unit)
    method : association method of the catalogue

    Returns
    -------
    Fix - covariance (3, 3) in north [m], east [m], heading [rad]

    Raises
    ------
    NoFix : TooFewPairs, NoAgreement, Ambiguous, Unobservable - a normal state at sea; the message says why
    """
    if not isinstance(epoch, Epoch):
        return _fix_of_window(tuple(epoch), method, radar, kernel)[0]
    association = associate(epoch, method=method, radar=radar)
    return with_integrity(adjust_visible_side(epoch, association, radar=radar, kernel=kernel))


def _fix_of_window(
    epochs: Sequence[Epoch], method: Method, radar: RadarModel | str, kernel: Kernel | str
) -> tuple[Fix, Association]:
    """Solve a window as a whole, with nothing known beforehand: associate its tracks, adjust all of its scans."""
    shared = association_method(method)
    if isinstance(shared, CpdModel):
        raise InputError("a window of epochs is associated jointly: method cpd does not apply to it")
    epochs = since_silence(epochs)
    found = solve_jointly(epochs, shared=shared, radar=radar)
    return with_window_integrity(refined(epochs, found, radar=radar, kernel=kernel)), found.association


def epochs(
    log: Log,
    *,
    radar: RadarModel | str = "imo",
    charted: Iterable[Mark] = (),
    at: datetime | None = None,
    last: bool = False,
    silent_s: float | None = None,
) -> Iterator[Epoch]:
    """Yield an epoch for each complete radar scan of a log: every one, the ``last``, or the newest ``at`` a time.

    With ``silent_s`` epochs without targets too, so often while radar is silent: own ship goes on meanwhile.
    """
    return _epochs(log.records, radar=radar, charted=charted, at=at, last=last, silent_s=silent_s)


def targets(
    history: Iterable[Epoch],
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    method: Method = "seeded",
    pairing: Pairing = "fix",
) -> TargetList:
    """Return the fused list of radar targets and AIS ships at the last of some epochs.

    Each sensor is filtered over the epochs by itself; the pairs and own place come from a fix of the last epoch. Where
    there is none, the list holds both apart and says why. With ``pairing`` "grey" the pairs come from the grey relation
    of the tracks over the epochs, about own places that are fixed every ten seconds: the source's method, to compare.

    Raises
    ------
    InputError : no epoch
    """
    solve = partial(answer, radar=radar, kernel=kernel, method=method)
    return listed(history, solve, radar=radar, pairing=pairing)


def answer_of_window(
    epochs: Sequence[Epoch],
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    method: Method = "seeded",
) -> Answer:
    """Solve a window of epochs together, with nothing known beforehand, and set beside the fix what `answer` sets."""
    newest = epochs[-1]
    clock = StepClock(newest.build_ms)
    try:
        found, association = _fix_of_window(tuple(epochs), method, radar, kernel)
    except NoFix as error:
        clock.lap("associate")
        return Answer(epoch=newest, error=error, timing_ms=clock.laps_ms)
    clock.lap("associate")
    return beside(found, association, newest, timing_ms=clock.laps_ms)
