r"""From a line of a log to the fields of a sentence: BOM, headers, TAG blocks, time stamps, checksum.

The forms that are understood, alone or together::

    $RATTM,01,1.07,...*3B                                     a plain sentence
    \s:RA0001,c:1216064717*29\$RATTM,...*3B                   TAG block: source and time (POSIX s or ms), group
    UdPbC<NUL>\s:RA0001,n:1*hh\$RATTM,...*3B                  datagram of IEC 61162-450
    2016-01-12T13:02:11.218Z $RATTM,...*3B                    stamped: ISO 8601 or POSIX s, ms, us; "," ";" or blanks
    !AIVDM,...*1B,r003669945,1272672306                       stamped at the end by a shore station, with its name
    # $RATTM,...                                              comment
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from functools import lru_cache, reduce
from operator import xor
from typing import NamedTuple

from navfix.errors import InputError

_SENTENCE = re.compile(r"([$!])(P[A-Z0-9]{2,9}|[A-Z][A-Z0-9]{4,9})(?=[,*])([^*]*)(?:\*([0-9A-Fa-f]{1,2}))?")
_TAG_GROUP = re.compile(r"(\d+)-(\d+)-(\w+)")
_ISO_STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?")
_POSIX_STAMP = re.compile(r"(?<![\d.:-])(\d{9,10}(?:\.\d+)?|\d{12,13}|\d{15,16})(?![\d:-])")
_CLOCK_STAMP = re.compile(r"(?<!\d)([01]\d|2[0-3]):([0-5]\d):([0-5]\d(?:\.\d+)?)(?!\d)")
_STATION = re.compile(r"[br][0-9A-Z_]{3,}")
_STATION_TIME = re.compile(r"[0-9]{9,10}")
_NOT_TEXT = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
_BOM = "\xef\xbb\xbf"
_UDPBC = "UdPbC\x00"
_LATEST_S = 4_102_444_800.0  # 2100-01-01: whatever lies later is no time


class Unreadable(InputError):
    """A line, or a part of it, that cannot be read; ``kind`` is the word that it is counted under."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind


class TagBlock(NamedTuple):
    """What a TAG block says: reception time [POSIX s], source, and (number, total, group name) of a group."""

    time_s: float | None = None
    source: str | None = None
    group: tuple[int, int, str] | None = None
    trouble: str | None = None


class Frame(NamedTuple):
    """A sentence taken out of its line.

    ``values[0]`` is the address, so that ``values[n]`` is field n of the standard. ``time_s`` [POSIX s] comes from TAG
    block or stamp; ``clock_s`` [s of the day] from a stamp without date. ``checked``: a checksum is there and right.
    """

    encapsulated: bool
    address: str
    values: list[str]
    checked: bool
    time_s: float | None = None
    clock_s: float | None = None
    source: str | None = None
    group: tuple[int, int, str] | None = None
    trouble: str | None = None

    @property
    def talker(self) -> str:
        return self.address[:-3] if self.formatter != self.address else ""

    @property
    def formatter(self) -> str:
        """Return the three letters behind the talker; a proprietary address ($P...) stays whole."""
        return self.address if self.address[0] == "P" else self.address[-3:]


def as_text(line: str | bytes) -> str:
    """Return the line with one character per byte (a str as its UTF-8 bytes), so that checksums stay right."""
    if isinstance(line, str):
        return line if line.isascii() else line.encode("utf-8", "replace").decode("latin-1")
    return line.decode("latin-1")


def checksum(text: str) -> int:
    """Return the exclusive or of the bytes of ``text`` as `as_text` gives it."""
    return reduce(xor, text.encode("latin-1"), 0)


def frame(text: str) -> Frame | None:
    """Take the sentence out of one line of `as_text`; None where the line is blank, a comment or a TAG block alone.

    Raises
    ------
    Unreadable : "no_sentence", "binary" (no text at all) or "checksum"
    """
    text = text.removeprefix(_BOM).removeprefix(_UDPBC).strip()
    if not text or text[0] == "#":
        return None
    tag, text = _split_tag_blocks(text) if text[0] == "\\" else (TagBlock(), text)
    match = _SENTENCE.search(text)
    if match is None:
        if not text and tag.trouble is None:
            return None
        raise _no_sentence(text)
    start, address, rest, printed = match.groups()
    body = address + rest
    _check(body, printed)
    time_s, clock_s, source, group, trouble = tag.time_s, None, tag.source, tag.group, tag.trouble
    if match.start() > 0 and time_s is None:
        time_s, clock_s = _stamp(text[: match.start()])
    if match.end() < len(text):
        station, station_time_s = _station_stamp(text[match.end() :])
        source = source or station
        time_s = time_s if time_s is not None else station_time_s
    return Frame(start == "!", address, body.split(","), printed is not None, time_s, clock_s, source, group, trouble)


def _check(body: str, printed: str | None) -> None:
    if printed is None:
        if _NOT_TEXT.search(body):
            raise _no_sentence(body)
    elif int(printed, 16) != (computed := checksum(body)):
        raise Unreadable("checksum", f"the checksum is printed *{printed}, the sentence gives *{computed:02X}")


def _no_sentence(text: str) -> Unreadable:
    if _NOT_TEXT.search(text):
        return Unreadable("binary", "bytes that are no text, expected a sentence that begins with $ or !")
    return Unreadable("no_sentence", "no sentence, expected one that begins with $ or ! and five letters")


# ------------------------------------------------------------------------------------------------ TAG blocks


def _split_tag_blocks(text: str) -> tuple[TagBlock, str]:
    """Return what all TAG blocks before the sentence say together, and the rest of the line."""
    tag = TagBlock()
    while text.startswith("\\"):
        content, closing, text = text[1:].partition("\\")
        if not closing:
            return tag._replace(trouble="the TAG block has no closing backslash"), content
        read = _read_tag_block(content)
        tag = TagBlock(
            read.time_s if tag.time_s is None else tag.time_s,
            tag.source or read.source,
            tag.group or read.group,
            tag.trouble or read.trouble,
        )
    return tag, text


@lru_cache(maxsize=64)
def _read_tag_block(content: str) -> TagBlock:
    body, star, printed = content.partition("*")
    if star and not _same_checksum(body, printed):
        return TagBlock(trouble=f"the TAG block's checksum is printed *{printed}, it gives *{checksum(body):02X}")
    time_s = source = group = trouble = None
    for item in body.split(","):
        key, _, value = item.partition(":")
        if key == "c":
            time_s = _posix_s(value)
            trouble = None if time_s is not None else f"the TAG block's time c:{value[:24]} is no POSIX time"
        elif key == "s":
            source = value or None
        elif key == "g" and (match := _TAG_GROUP.fullmatch(value)):
            group = (int(match[1][:9]), int(match[2][:9]), match[3])
    return TagBlock(time_s, source, group, trouble)


def _same_checksum(body: str, printed: str) -> bool:
    return re.fullmatch("[0-9A-Fa-f]{1,2}", printed) is not None and int(printed, 16) == checksum(body)


# ----------------------------------------------------------------------------------------------- time stamps


def _posix_s(text: str) -> float | None:
    """Read POSIX seconds, milliseconds or microseconds, told apart by their size."""
    if not re.fullmatch(r"[0-9]{1,16}(\.[0-9]*)?", text):
        return None
    value = float(text)
    for scale in (1.0, 1e-3, 1e-6):
        if 0.0 < value * scale < _LATEST_S:
            return value * scale
    return None


def _stamp(prefix: str) -> tuple[float | None, float | None]:
    """Return POSIX seconds, or else seconds of the day, of what stands before a sentence; without zone it is UTC."""
    if match := _ISO_STAMP.search(prefix):
        try:
            stamp = datetime.fromisoformat(match[0].replace(",", "."))
            return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp(), None
        except (ValueError, OverflowError):
            return None, None
    if match := _POSIX_STAMP.search(prefix):
        return _posix_s(match[1]), None
    if match := _CLOCK_STAMP.search(prefix):
        return None, int(match[1]) * 3600.0 + int(match[2]) * 60.0 + float(match[3])
    return None, None


def _station_stamp(suffix: str) -> tuple[str | None, float | None]:
    """Return name and POSIX seconds that a shore station wrote behind a sentence: ``,d-109,r003669946,1325394060``."""
    items = suffix.strip().split(",")
    for index, item in enumerate(items):
        if _STATION.fullmatch(item):
            times = (_posix_s(later) for later in items[index + 1 :] if _STATION_TIME.fullmatch(later))
            return item, next(times, None)
    return None, None
