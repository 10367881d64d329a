"""Gaps in AIS: outages whose ages since the last update follow a published table.

Source: AIS statistics of the Waigaoqiao waters, port of Shanghai, 27 to 28 April 2011 (paper on the correction of AIS
tracks by the unscented Kalman filter): at any instant about 30 % of the ships had no update for 2 minutes, 15 % for 3,
10 % for 5 and 2 % for 15 minutes.

Model: reporting and outage alternate. At a random instant P(age > x) = integral of P(outage > y) over y > x, divided by
the mean cycle; between the table's ages P(outage > y) is taken as constant, which gives outages of few fixed lengths
and meets the table exactly at its ages. Gaps of the report intervals come on top.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from navfix.errors import InputError


@dataclass(frozen=True, slots=True)
class OutageModel:
    """Outages of ``lengths_s`` with ``probabilities``, and reporting for ``mean_up_s`` (exponential) between them."""

    lengths_s: tuple[float, ...]
    probabilities: tuple[float, ...]
    mean_up_s: float


def outage_model(age_min: tuple[float, ...], share_older: tuple[float, ...], *, longest_min: float) -> OutageModel:
    """Return the model that meets a table: ``share_older`` of the stations have no update for ``age_min`` minutes.

    Raises
    ------
    InputError : ages that do not rise, shares that fall too slowly first for outages to exist
    """
    ages, shares = (*age_min, longest_min), (*share_older, 0.0)
    density = [(g - h) / (b - a) for (a, b), (g, h) in zip(pairwise(ages), pairwise(shares), strict=True)]
    if any(b <= a for a, b in pairwise(ages)) or any(later > sooner for sooner, later in pairwise(density)):
        raise InputError("an outage table needs rising ages and shares that fall ever more slowly")
    cycle_min = 1.0 / density[0]
    survival = [d * cycle_min for d in density] + [0.0]
    probabilities = tuple(a - b for a, b in pairwise(survival))
    mean_min = sum(length * p for length, p in zip(ages[1:], probabilities, strict=True))
    if mean_min >= cycle_min:
        raise InputError("the outage table leaves no time for reporting")
    return OutageModel(tuple(60.0 * age for age in ages[1:]), probabilities, 60.0 * (cycle_min - mean_min))


WAIGAOQIAO = outage_model((2.0, 3.0, 5.0, 15.0), (0.30, 0.15, 0.10, 0.02), longest_min=25.0)


def draw_outages(model: OutageModel, duration_s: float, rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return the outages (start, end) [s] that touch a recording, the process being long under way when it starts."""
    outages: list[tuple[float, float]] = []
    time_s = -float(rng.uniform(20.0, 40.0)) * max(model.lengths_s)
    while time_s < duration_s:
        time_s += float(rng.exponential(model.mean_up_s))
        length_s = float(rng.choice(model.lengths_s, p=model.probabilities))
        if time_s + length_s > 0.0 and time_s < duration_s:
            outages.append((time_s, time_s + length_s))
        time_s += length_s
    return outages


def in_outage(outages: list[tuple[float, float]], time_s: float) -> bool:
    """Return whether a time falls into one of the outages (ordered, apart)."""
    index = bisect_right(outages, (time_s, float("inf"))) - 1
    return index >= 0 and time_s < outages[index][1]
