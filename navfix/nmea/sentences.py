"""Which sentence is read by which function, and which of them tell the time."""

from __future__ import annotations

from collections.abc import Callable

from navfix.nmea import own_ship, radar
from navfix.nmea.fields import Fields
from navfix.nmea.framing import Frame
from navfix.nmea.records import OtherMessage, Record

Parser = Callable[[Frame, Fields, float | None], tuple[Record, ...]]

PARSERS: dict[str, Parser] = {
    "TTM": radar.target,
    "RSD": radar.settings,
    "OSD": own_ship.osd,
    "HDT": own_ship.hdt,
    "THS": own_ship.ths,
    "HDG": own_ship.hdg,
    "HDM": own_ship.hdm,
    "VHW": own_ship.vhw,
    "ROT": own_ship.rot,
    "VBW": own_ship.vbw,
    "VTG": own_ship.vtg,
    "RMC": own_ship.rmc,
    "GGA": own_ship.gga,
    "GLL": own_ship.gll,
    "GNS": own_ship.gns,
    "ZDA": own_ship.zda,
}

# formatter -> field with UTC of day, rank of that clock (0 is believed first: GNSS before the radar's own clock)
_UTC_FIELDS = {"GGA": (1, 1), "GNS": (1, 1), "GLL": (5, 1), "TTM": (14, 2), "TLL": (7, 2)}

TIMED = ("RMC", "ZDA", *_UTC_FIELDS)


def records_of(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read one parametric sentence; one `OtherMessage` where it says nothing that navfix uses.

    Raises
    ------
    navfix.nmea.framing.Unreadable : a field that must be right is not
    """
    parser = PARSERS.get(frame.formatter)
    records = parser(frame, fields, time_s) if parser is not None else ()
    return records or (OtherMessage(time_s, frame.formatter, frame.source),)


def sentence_time(frame: Frame) -> tuple[int, float, bool] | None:
    """Return rank of the clock, its time, whether that is POSIX seconds (else of the day); None without time."""
    formatter = frame.formatter
    if formatter in _UTC_FIELDS:
        index, rank = _UTC_FIELDS[formatter]
        utc_of_day_s = Fields(frame.values).utc_of_day_s(index)
        return None if utc_of_day_s is None else (rank, utc_of_day_s, False)
    if formatter not in ("RMC", "ZDA"):
        return None
    fields = Fields(frame.values)
    utc_s = own_ship.utc_of_rmc(fields) if formatter == "RMC" else own_ship.utc_of_zda(fields)
    if utc_s is not None:
        return 0, utc_s, True
    utc_of_day_s = fields.utc_of_day_s(1)
    return None if utc_of_day_s is None else (1, utc_of_day_s, False)
