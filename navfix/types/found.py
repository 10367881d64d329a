"""What is found: the association of targets and marks, and the other places that explain them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from navfix.errors import InputError
from navfix.types.checks import FloatArray, IntArray, frozen_array, require
from navfix.types.observed import Epoch
from navfix.types.places import PlanePosition, Position

LARGEST_MARGIN = 1000.0  # nats: what is stated where there is no other place at all


@dataclass(frozen=True, slots=True)
class Alternative:
    """One place that explains the data; ``score`` is its log evidence, comparable within one epoch."""

    position: Position | PlanePosition
    heading_deg: float | None
    score: float
    pairs: int = 0


@dataclass(frozen=True, slots=True)
class SecondGroup:
    """Targets that agree with each other on another place: the sign of AIS positions shifted alike."""

    offset_m: float
    azimuth_deg: float
    targets: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Association:
    """Which target is which mark.

    ``pairs`` is (k, 2): target index, mark index; ``probability`` (k,) in 0 .. 1. The pose (``position``,
    ``heading_deg``, ``covariance`` (3, 3) in north m, east m, heading rad) is None when the pairs were given by hand.
    ``evidence`` and ``margin`` are natural logarithms; ``probability_wrong`` is that of another place.
    """

    pairs: IntArray
    probability: FloatArray
    position: Position | None = None
    heading_deg: float | None = None
    covariance: FloatArray | None = None
    evidence: float | None = None
    margin: float | None = None
    probability_wrong: float | None = None
    alternatives: tuple[Alternative, ...] = ()
    second_group: SecondGroup | None = None
    method: str = "by_hand"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        pairs = frozen_array(self.pairs, np.int64).reshape(-1, 2)
        pairs.setflags(write=False)
        object.__setattr__(self, "pairs", pairs)
        object.__setattr__(self, "probability", frozen_array(self.probability, np.float64))
        require(
            len(self.pairs) == len(self.probability),
            "probability",
            f"must have {len(self.pairs)} entries",
            len(self.probability),
        )
        for column, word in ((0, "target"), (1, "mark")):
            indices = self.pairs[:, column]
            require(len(np.unique(indices)) == len(indices), "pairs", f"must name each {word} once", indices.tolist())
        if self.covariance is not None:
            object.__setattr__(self, "covariance", frozen_array(self.covariance, np.float64))

    @classmethod
    def from_pairs(cls, epoch: Epoch, pairs: Iterable[tuple[int | str, int | str]]) -> Association:
        """Make an association by hand from (target, mark) given as indices or labels.

        Raises
        ------
        InputError : an index out of range, an unknown or doubled label, a target or mark named twice
        """
        resolved = [
            (
                _find(target, [t.label for t in epoch.targets], "target"),
                _find(mark, [m.label for m in epoch.marks], "mark"),
            )
            for target, mark in pairs
        ]
        return cls(pairs=np.array(resolved, dtype=np.int64).reshape(-1, 2), probability=np.ones(len(resolved)))


def _find(key: int | str, labels: Sequence[str], word: str) -> int:
    if isinstance(key, str):
        hits = [index for index, label in enumerate(labels) if label == key]
        if len(hits) != 1:
            why = "unknown" if not hits else "more than one has this label"
            raise InputError(f"{word} {key!r}: {why}; labels are {', '.join(labels[:20])}")
        return hits[0]
    if not 0 <= int(key) < len(labels):
        raise InputError(f"{word} index {key} is out of range: there are {len(labels)} {word}s")
    return int(key)
