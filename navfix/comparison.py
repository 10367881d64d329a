"""The robust fix beside what it wants to beat: least squares, other kernels, the plain mean and its variants."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from navfix.adjustment import adjust, mean_fix
from navfix.adjustment.visible_side import adjust_visible_side
from navfix.catalog import RadarModel
from navfix.errors import InputError, NoFix
from navfix.geodesy import inverse
from navfix.kernels import Kernel
from navfix.types import Association, Ellipse, Epoch, PlanePosition, Position

KERNELS = ("none", "huber", "hampel", "danish", "tukey")
MEAN_WEIGHTS = {"ship": 1.0, "aton": 3.0, "charted": 3.0}


@dataclass(frozen=True, slots=True)
class Row:
    """One method's place; ``reason`` says why there is none. ``error_m`` where the truth is known.

    The ellipse of an adjustment is that of the fix; the ellipse of a mean is the spread of the single places, as its
    source draws it.
    """

    method: str
    position: Position | None
    ellipse: Ellipse | None
    from_robust_m: float | None = None
    error_m: float | None = None
    reason: str | None = None


def compare(
    epoch: Epoch,
    association: Association,
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    truth: Position | None = None,
) -> tuple[Row, ...]:
    """Fix one epoch by every method, from the same pairs; the first row is the robust fix with ``kernel``."""
    epoch = _seen(epoch, association, radar, kernel)
    rows = [*_adjustments(epoch, association, radar, kernel), *_means(epoch, association)]
    robust = rows[0].position
    return tuple(
        Row(
            row.method, row.position, row.ellipse, _apart(robust, row.position), _apart(truth, row.position), row.reason
        )
        for row in rows
    )


def _seen(epoch: Epoch, association: Association, radar: RadarModel | str, kernel: Kernel | str) -> Epoch:
    """Return the epoch with the hulls as seen from the robust fix: every method takes the same marks."""
    try:
        return adjust_visible_side(epoch, association, radar=radar, kernel=kernel).epoch or epoch
    except NoFix:
        return epoch


def _adjustments(
    epoch: Epoch, association: Association, radar: RadarModel | str, kernel: Kernel | str
) -> Iterator[Row]:
    chosen = kernel if isinstance(kernel, str) else kernel.name
    others = [name for name in KERNELS if name != chosen]
    for which in (kernel, *others):
        name = which if isinstance(which, str) else which.name
        label = "least squares" if name == "none" else name
        try:
            fix = adjust(epoch, association, radar=radar, kernel=which)
        except NoFix as error:
            yield Row(label, None, None, reason=str(error))
            continue
        yield Row(label, fix.position if isinstance(fix.position, Position) else None, fix.ellipse(0.95))


def _means(epoch: Epoch, association: Association) -> Iterator[Row]:
    variants: dict[str, dict[str, object]] = {
        "plain mean": {},
        "mean after rejection": {"reject": True},
        "weighted mean (aids x 3)": {"weights": MEAN_WEIGHTS},
        "plain mean, bearing + 180": {"literal": True},
    }
    for label, options in variants.items():
        try:
            mean = mean_fix(epoch, association, **options)  # type: ignore[arg-type]
        except (NoFix, InputError) as error:
            yield Row(label, None, None, reason=str(error))
            continue
        yield Row(label, mean.position, mean.ellipse(0.95))


def _apart(one: Position | PlanePosition | None, other: Position | None) -> float | None:
    if not isinstance(one, Position) or other is None:
        return None
    return inverse(one, other)[0]
