"""AIS sentences to whole payloads: parts that arrive in turn, out of turn or mixed with those of other messages."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from navfix.nmea.framing import Frame, Unreadable

_PAYLOAD = re.compile(r"[0-W`-w]+")
_MAX_WAITING = 64
_MAX_SENTENCES_APART = 200
_MAX_SECONDS_APART = 30.0


class Payload(NamedTuple):
    """One whole message: six-bit armoured text, number of fill bits, reception time of its first part, source."""

    text: str
    fill_bits: int
    time_s: float | None
    own: bool
    source: str | None

    @property
    def message_type(self) -> int:
        """Return the message type, which the first character tells alone."""
        code = ord(self.text[0]) - 48
        return code - 8 if code > 40 else code

    @property
    def bits(self) -> int:
        """Return the length of the message."""
        return 6 * len(self.text) - self.fill_bits


class _Key(NamedTuple):
    address: str
    sequence: str
    channel: str
    group: str | None
    source: str | None = None


@dataclass(slots=True)
class _Waiting:
    total: int
    since: int
    time_s: float | None
    parts: dict[int, tuple[str, int]] = field(default_factory=dict)


class PartAssembler:
    """Collects the parts of messages of one log; ``lost`` counts messages of which a part never came."""

    def __init__(self) -> None:
        self.lost = 0
        self._sentences = 0
        self._waiting: dict[_Key, _Waiting] = {}

    def feed(self, frame: Frame, time_s: float | None) -> Payload | None:
        """Take one VDM or VDO sentence; return the whole message when this was its last missing part.

        Fields: 1 number of parts, 2 this part, 3 sequence, 4 channel, 5 payload, 6 fill bits; more are ignored.
        The parts of one message share talker, sequence, channel and source, or talker, sequence and the
        name of their TAG group.

        Raises
        ------
        Unreadable : "ais_sentence" (numbers, length), "ais_empty" (no payload), "ais_payload" (characters)
        """
        self._sentences += 1
        total, number, fill_bits, text = _checked(frame)
        own = frame.address.endswith("VDO")
        if total == 1:
            return Payload(text, fill_bits, time_s, own, frame.source)
        key = self._match(self._key(frame))
        waiting = self._open(key, total, number, time_s)
        waiting.parts[number] = (text, fill_bits)
        if len(waiting.parts) < total:
            return None
        del self._waiting[key]
        whole = "".join(waiting.parts[n][0] for n in range(1, total + 1))
        return Payload(whole, waiting.parts[total][1], waiting.time_s, own, frame.source)

    def close(self) -> None:
        """Give up what still waits and count it as lost."""
        self.lost += len(self._waiting)
        self._waiting.clear()

    @staticmethod
    def _key(frame: Frame) -> _Key:
        if frame.group is not None and frame.group[1] > 1:
            return _Key(frame.address, frame.values[3], "", frame.group[2])
        return _Key(frame.address, frame.values[3], frame.values[4], None, frame.source)

    def _match(self, key: _Key) -> _Key:
        """Return the key of a waiting message that this part belongs to when only one of its parts names the source."""
        if key not in self._waiting:
            for other in self._waiting:
                if key[:4] == other[:4] and (key.source is None or other.source is None):
                    return other
        return key

    def _open(self, key: _Key, total: int, number: int, time_s: float | None) -> _Waiting:
        waiting = self._waiting.get(key)
        if waiting is None or not self._belongs(waiting, total, number, time_s):
            self.lost += waiting is not None
            self._waiting.pop(key, None)
            if len(self._waiting) >= _MAX_WAITING:
                del self._waiting[next(iter(self._waiting))]
                self.lost += 1
            waiting = self._waiting[key] = _Waiting(total, self._sentences, time_s)
        if waiting.time_s is None:
            waiting.time_s = time_s
        return waiting

    def _belongs(self, waiting: _Waiting, total: int, number: int, time_s: float | None) -> bool:
        in_time = time_s is None or waiting.time_s is None or abs(time_s - waiting.time_s) <= _MAX_SECONDS_APART
        near = self._sentences - waiting.since <= _MAX_SENTENCES_APART
        return waiting.total == total and number not in waiting.parts and in_time and near


def _checked(frame: Frame) -> tuple[int, int, int, str]:
    values = frame.values
    if len(values) < 7:
        raise Unreadable("ais_sentence", f"{len(values) - 1} fields, expected at least 6")
    total, number, fill_bits = (_digit(values[index], name) for index, name in _COUNTS)
    if not 1 <= number <= total:
        raise Unreadable("ais_sentence", f"part {number} of {total}")
    if fill_bits > 5:
        raise Unreadable("ais_sentence", f"{fill_bits} fill bits, expected 0 .. 5")
    text = values[5].strip()
    if not text:
        raise Unreadable("ais_empty", "no payload")
    if not _PAYLOAD.fullmatch(text):
        raise Unreadable("ais_payload", "characters that the six-bit code does not have")
    return total, number, fill_bits, text


_COUNTS = ((1, "number of parts"), (2, "part"), (6, "fill bits"))


def _digit(text: str, name: str) -> int:
    if len(text) != 1 or text not in "0123456789":
        raise Unreadable("ais_sentence", f"{name} {text[:24]!r}, expected one digit")
    return int(text)
