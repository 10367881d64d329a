"""The stream reader: lines in, records out; it keeps count and never fails on a line."""

from __future__ import annotations

import dataclasses
from collections import Counter
from typing import Literal

from navfix.nmea import ais, sentences
from navfix.nmea.ais_parts import PartAssembler
from navfix.nmea.clock import SentenceClock
from navfix.nmea.fields import Fields
from navfix.nmea.framing import Frame, Unreadable, as_text, frame
from navfix.nmea.records import OwnHeading, Record

TimeBasis = Literal["reception", "sentence", "time_of_day", "none"]
_TEXT_SHOWN = 80
_LINES_OF_A_STAMP = 200


@dataclasses.dataclass(frozen=True, slots=True)
class Problem:
    """Lines that could not be read, or not wholly, for one kind of reason; text and message are those of the first."""

    kind: str
    count: int
    first_line: int
    first_text: str
    message: str

    def __str__(self) -> str:
        """Return one line for the log."""
        first = f"first in line {self.first_line}: {self.message}"
        return f"{self.count} x {self.kind}, {first}" + (f": {self.first_text}" if self.first_text else "")


class Reader:
    """Reads the lines of one log or one stream.

    Parameters
    ----------
    start_s : date and time [POSIX s] at which a log without time stamps begins, where it is known beforehand

    Attributes
    ----------
    counts : sentences that are framed well and whose checksum is right or absent, those of no use to navfix too;
        ``$`` sentences under their formatter ("TTM"), ``!`` sentences under their address ("AIVDM", "AIVDO", "BSVDM").
        Parts of one AIS message count one by one.
    lines : lines seen, blank ones and comments too

    Notes
    -----
    The time of a record is that of the TAG block, else of the stamp on the line, else ``at`` of `feed`, else that of
    such a line shortly before, else the UTC that the sentences tell (`navfix.nmea.clock`).

    A sentence without checksum is believed while its sender has never sent one: a sender that did was cut short.
    """

    def __init__(self, *, start_s: float | None = None) -> None:
        self.counts: Counter[str] = Counter()
        self.lines = 0
        self._problems: dict[str, Problem] = {}
        self._parts = PartAssembler()
        self._lost = 0
        self._clock = SentenceClock(start_s)
        self._received_s: float | None = None
        self._received_line = 0
        self._senders_with_checksum: set[str] = set()
        self._variation_deg: float | None = None

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Return what could not be read, most frequent first."""
        return tuple(sorted(self._problems.values(), key=lambda problem: -problem.count))

    @property
    def time_basis(self) -> TimeBasis:
        """Return where times come from: "time_of_day" means that no date is known and the first day is 1970-01-01."""
        return "reception" if self._received_s is not None else self._clock.basis

    def feed(self, line: str | bytes, at: float | None = None) -> list[Record]:
        """Read one line, or the lines of one datagram, received at ``at`` [POSIX s].

        Returns
        -------
        list of Record - empty for a blank line, a comment, a part of a message that is not complete, or a problem
        """
        text = as_text(line)
        records: list[Record] = []
        for single in text.splitlines() if "\n" in text.rstrip("\r\n") else (text,):
            self.lines += 1
            try:
                records += self._read(single, at)
            except Unreadable as problem:
                self._note(problem.kind, str(problem), single)
        return records

    def close(self) -> None:
        """End the stream: count the AIS messages of which a part never came."""
        self._parts.close()
        self._note_lost_parts("")

    def _read(self, text: str, at: float | None) -> tuple[Record, ...]:
        found = frame(text)
        if found is None:
            return ()
        if found.trouble is not None:
            self._note("tag_block", found.trouble, text)
        self._check_sender(found)
        self.counts[found.address if found.encapsulated else found.formatter] += 1
        time_s = self._time(found, at)
        if found.encapsulated:
            return self._read_encapsulated(found, time_s, text)
        fields = Fields(found.values)
        records = sentences.records_of(found, fields, time_s)
        if fields.notes:
            self._note("field", f"{found.formatter}: {fields.notes[0]}", text)
        return self._with_variation(records) if isinstance(records[0], OwnHeading) else records

    def _read_encapsulated(self, found: Frame, time_s: float | None, text: str) -> tuple[Record, ...]:
        if found.formatter not in ("VDM", "VDO"):
            return sentences.records_of(found, Fields(found.values), time_s)
        payload = self._parts.feed(found, time_s)
        self._note_lost_parts(text)
        return () if payload is None else ais.records_of(payload)

    def _note_lost_parts(self, text: str) -> None:
        while self._lost < self._parts.lost:
            self._lost += 1
            self._note("ais_incomplete", "an AIS message was given up, a part of it never came", text)

    def _check_sender(self, found: Frame) -> None:
        if found.checked:
            self._senders_with_checksum.add(found.address)
        elif found.address in self._senders_with_checksum:
            raise Unreadable("no_checksum", f"{found.address} without the checksum that it had before: cut short")

    def _time(self, found: Frame, at: float | None) -> float | None:
        received_s = found.time_s if found.time_s is not None else at
        if received_s is not None:
            self._received_s, self._received_line = received_s, self.lines
            return received_s
        self._hear_time(found)
        recent = self._received_s is not None and self.lines - self._received_line <= _LINES_OF_A_STAMP
        return self._received_s if recent or self._clock.now_s is None else self._clock.now_s

    def _hear_time(self, found: Frame) -> None:
        told = None if found.encapsulated else sentences.sentence_time(found)
        if told is not None:
            rank, utc_s, dated = told
            if dated:
                self._clock.dated(utc_s, rank=rank, speaker=found.address)
            else:
                self._clock.time_of_day(utc_s, rank=rank, speaker=found.address)
        elif found.clock_s is not None:
            self._clock.time_of_day(found.clock_s, rank=3, speaker="stamp")

    def _with_variation(self, records: tuple[Record, ...]) -> tuple[Record, ...]:
        """Give a magnetic heading without variation that of the last HDG; RMC's comes from own GNSS and is not used."""
        heading = records[0]
        if not isinstance(heading, OwnHeading) or heading.reference != "magnetic":
            return records
        if heading.variation_deg is not None:
            self._variation_deg = heading.variation_deg
            return records
        return (dataclasses.replace(heading, variation_deg=self._variation_deg), *records[1:])

    def _note(self, kind: str, message: str, text: str) -> None:
        known = self._problems.get(kind)
        if known is None:
            shown = "".join(c if " " <= c <= "~" else "?" for c in text.strip()[:_TEXT_SHOWN])
            self._problems[kind] = Problem(kind, 1, self.lines, shown, message)
        else:
            self._problems[kind] = dataclasses.replace(known, count=known.count + 1)
