"""The lines of a report on the place that is held over time: how it stands, and what no figure covers."""

from __future__ import annotations

from collections.abc import Iterator

from navfix.report import words
from navfix.report.entries import entry
from navfix.types import TrackState
from navfix.types.found import LARGEST_MARGIN

_WORDS = {"dead_reckoning": "DEAD RECKONING ONLY"}


def track_lines(track: TrackState | None) -> Iterator[str]:
    """Yield how the held place stands; nothing where scans are solved alone or no place is held."""
    if track is None or track.since_s is None:
        return
    parts = [f"{_WORDS.get(track.status, track.status)}, held for {track.since_s:.0f} s"]
    if track.confirmed_age_s is not None:
        parts.append(f"found {track.confirmed_age_s:.0f} s ago by a solve that does not know it")
    if track.ahead is not None:
        alone = track.ahead >= LARGEST_MARGIN
        parts.append("no other place beside it" if alone else f"ahead of every other place by {track.ahead:.1f}")
    if track.probability_wrong is not None:
        parts.append(f"{words.odds(track.probability_wrong)} that it is wrong")
    yield from entry("Track", "; ".join(parts))
    if track.not_checked:
        yield from entry("Not checked", "; ".join(track.not_checked))
