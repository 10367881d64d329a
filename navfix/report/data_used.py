"""Which data a fix is made from and how chart and AIS agree: in words, and for the JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from navfix.report import words
from navfix.report.numbers import plain
from navfix.types import ChartCheck, Epoch, MethodChoice, OffStation

_LISTED = 5


def data_entries(epoch: Epoch | None) -> Iterator[tuple[str, str]]:
    """Yield (label, text) for the report: what the chart adds, then which data were used and why."""
    if epoch is None:
        return
    if epoch.chart is not None:
        yield "Chart", _chart(epoch.chart)
        for aid in epoch.chart.off_station[:_LISTED]:
            yield "", f"- {off_station_words(aid)}"
    if epoch.choice is not None:
        yield "Choice", _choice(epoch.choice)


def off_station_words(aid: OffStation) -> str:
    """Return a sentence that names an aid off station: how far, in which direction, from what."""
    who = f"{aid.name} ({aid.mmsi})" if aid.name else str(aid.mmsi)
    where = f"{words.distance(aid.distance_m)} along {words.direction(aid.azimuth_deg)} from charted {aid.charted}"
    return f"{who} off station by {'its own word' if aid.flagged else 'AIS'}: {where}; left out"


def chart_cautions(epoch: Epoch) -> tuple[str, ...]:
    """Return what must not be missed: chart and AIS differ by one vector."""
    check = epoch.chart
    if check is None or check.shift_m is None or check.shift_azimuth_deg is None:
        return ()
    where = f"{words.distance(check.shift_m)} along {words.direction(check.shift_azimuth_deg)}"
    return (
        f"AIS aids are off their charted places alike, {where}: the chart's datum is not WGS 84, or the AIS positions "
        "are shifted together. Check the position with something that is neither.",
    )


def chart_to_dict(check: ChartCheck | None) -> dict[str, Any] | None:
    """Return the check of chart against AIS, None without a chart."""
    if check is None:
        return None
    return {
        "charted": check.charted,
        "in_reach": check.in_reach,
        "added": check.added,
        "confirmed": list(check.confirmed),
        "off_station": [
            {
                "mmsi": aid.mmsi,
                "name": aid.name,
                "charted": aid.charted,
                "distance_m": plain(aid.distance_m),
                "azimuth_deg": plain(aid.azimuth_deg),
                "flagged": aid.flagged,
            }
            for aid in check.off_station
        ],
        "not_charted": list(check.not_charted),
        "shift_m": plain(check.shift_m),
        "shift_azimuth_deg": plain(check.shift_azimuth_deg),
    }


def choice_to_dict(choice: MethodChoice | None) -> dict[str, Any] | None:
    """Return the choice of data with its reason, None where none was made."""
    if choice is None:
        return None
    return {
        "ships": choice.ships,
        "own_speed": choice.own_speed,
        "three_aids": choice.three_aids,
        "source_choice": choice.source,
        "filters": list(choice.filters),
        "decision": choice.decision,
        "choice_reason": choice.reason,
    }


def _chart(check: ChartCheck) -> str:
    parts = [f"{check.added} added to AIS", f"{len(check.confirmed)} confirm an AIS aid"]
    if check.off_station:
        parts.append(f"{len(check.off_station)} off station")
    if check.not_charted:
        parts.append(f"{len(check.not_charted)} AIS aids not charted")
    return f"{check.in_reach} of {words.plural(check.charted, 'charted mark')} in reach: {', '.join(parts)}"


def _choice(choice: MethodChoice) -> str:
    used = {"all": "all data", "source": "as the source's table says", "none": "nothing to use"}[choice.decision]
    return f"{used} ({choice.reason}). The source's table: {choice.source}"
