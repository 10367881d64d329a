"""The method from one end to the other: log -> epochs -> association -> adjustment -> answer."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from functools import cache, partial

from navfix.adjustment import graph, mean_fix
from navfix.adjustment.visible_side import adjust_visible_side
from navfix.association import associate
from navfix.association.window.associate import solve_jointly
from navfix.association.window.tracks import since_silence
from navfix.catalog import AssociationModel, CpdModel, RadarModel, association_method
from navfix.errors import InputError, NoFix
from navfix.integrity import GnssMonitor, gnss_verdict, with_integrity, with_window_integrity
from navfix.integrity.cautions import association_cautions, heading_notes
from navfix.kernels import Kernel
from navfix.nmea import Log
from navfix.picture import epochs as _epochs
from navfix.refinement import refined
from navfix.report.answer import Answer
from navfix.report.data_used import chart_cautions
from navfix.report.timing import StepClock
from navfix.target_list import listed
from navfix.types import Association, Epoch, Fix, Mark, MeanFix, Pairing, TargetList

__all__ = ["answer", "answer_of_window", "beside", "epochs", "fix", "targets", "watched"]

Method = str | AssociationModel | CpdModel


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


def answer(
    epoch: Epoch,
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    method: Method = "seeded",
    prove: bool = False,
    association: Association | None = None,
) -> Answer:
    """Solve an epoch as `fix` does and set beside it the plain-mean fix, the GNSS verdict and the time that it took.

    No fix is an answer too: it is in ``error``, nothing is raised. Pairs by hand are given as ``association``; with
    ``prove`` every other place is excluded by an exhaustive search.
    """
    _load_libraries()
    clock = StepClock(epoch.build_ms)
    step = "associate"
    cautions = chart_cautions(epoch)
    try:
        if association is None:
            association = associate(epoch, method=method, radar=radar, prove=prove)
        clock.lap(step)
        step, cautions = "adjust", (*cautions, *association_cautions(association, epoch))
        found = with_integrity(adjust_visible_side(epoch, association, radar=radar, kernel=kernel))
        clock.lap(step)
    except NoFix as error:
        clock.lap(step)
        return Answer(epoch=epoch, error=error, timing_ms=clock.laps_ms, cautions=cautions)
    seen = found.epoch or epoch
    return Answer(
        epoch=seen,
        fix=found,
        plain_mean=_plain_mean(seen, association),
        gnss=None if epoch.gnss is None else gnss_verdict(found, epoch.gnss),
        timing_ms=clock.laps_ms,
        notes=(*heading_notes(found, epoch), *association.notes),
        cautions=cautions,
    )


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


def beside(
    found: Fix, association: Association | None, epoch: Epoch, *, timing_ms: Mapping[str, float] | None = None
) -> Answer:
    """Return the answer of a fix that was found over time: GNSS verdict, plain mean, cautions and notes beside it."""
    pairs = association is not None and len(association.pairs) > 0
    return Answer(
        epoch=epoch,
        fix=found,
        plain_mean=_plain_mean(epoch, association) if pairs and association is not None else None,
        gnss=None if epoch.gnss is None else gnss_verdict(found, epoch.gnss),
        timing_ms=timing_ms or {},
        notes=(*heading_notes(found, epoch), *(association.notes if association is not None else ())),
        cautions=association_cautions(association, epoch) if pairs and association is not None else (),
    )


def watched(answered: Answer, monitor: GnssMonitor) -> Answer:
    """Return the answer with the GNSS verdict that lasts over the epochs fed to ``monitor``, in their order."""
    epoch, gnss = answered.epoch, answered.gnss
    report = None if epoch is None else epoch.gnss
    if report is not None and gnss is not None:
        report = replace(report, position=gnss.position)  # carried to the ship's reference point, where that is known
    at = None if epoch is None else epoch.time_utc
    return replace(answered, gnss=monitor.feed(answered.fix, report, at))


def _plain_mean(epoch: Epoch, association: Association) -> MeanFix | None:
    """Return the plain-mean fix, None where its method fails (within miles of a pole): the fix stands without it."""
    try:
        return mean_fix(epoch, association)
    except (NoFix, InputError):
        return None


@cache
def _load_libraries() -> None:
    """Import what the first solve needs before its time is taken."""
    graph.load()
    importlib.import_module("scipy.optimize")
