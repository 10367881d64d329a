"""A fix or the reason why there is none, and beside it the plain mean, the GNSS verdict, cautions and notes."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

from navfix.adjustment import graph, mean_fix
from navfix.adjustment.visible_side import adjust_visible_side
from navfix.association import associate
from navfix.catalog import AssociationModel, CpdModel, RadarModel
from navfix.errors import InputError, NoFix
from navfix.integrity import GnssMonitor, gnss_verdict, with_integrity
from navfix.integrity.cautions import association_cautions, heading_notes
from navfix.kernels import Kernel
from navfix.report.answer import Answer
from navfix.report.data_used import chart_cautions
from navfix.report.timing import StepClock
from navfix.types import Association, Epoch, Fix, MeanFix

Method = str | AssociationModel | CpdModel


def answer(
    epoch: Epoch,
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    method: Method = "seeded",
    prove: bool = False,
    association: Association | None = None,
) -> Answer:
    """Solve an epoch as `navfix.fix` does; beside it stand the plain-mean fix, the GNSS verdict and the time it took.

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
