"""A whole log read at once."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, cast

from navfix.errors import InputError
from navfix.nmea import sentences
from navfix.nmea.clock import DAY_S
from navfix.nmea.framing import Unreadable, as_text, frame
from navfix.nmea.reader import Problem, Reader, TimeBasis
from navfix.nmea.records import Record

_TIMED = tuple(f"{formatter}," for formatter in sentences.TIMED)
_logger = logging.getLogger(__name__)

R = TypeVar("R")


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """The records of one log in the order of its lines, and the account of what was read.

    ``counts``, ``problems`` and ``lines`` as in `navfix.nmea.reader.Reader`. ``time_basis`` says where the times come
    from; "time_of_day" means that no date is known and that the first day is 1970-01-01.
    """

    name: str
    records: tuple[Record, ...]
    counts: Mapping[str, int]
    problems: tuple[Problem, ...]
    lines: int
    time_basis: TimeBasis
    _by_type: dict[type, tuple[Any, ...]] = field(default_factory=dict, init=False, repr=False)

    @property
    def sentences(self) -> int:
        """Return how many sentences were read; 0 for a text in which there is no NMEA."""
        return sum(self.counts.values())

    @property
    def time_known(self) -> bool:
        """Return whether the records carry real dates and times."""
        return self.time_basis in ("reception", "sentence")

    def of(self, kind: type[R]) -> tuple[R, ...]:
        """Return the records of one type, in order: ``log.of(TargetReport)``."""
        if not self._by_type:
            groups: dict[type, list[Any]] = {}
            for record in self.records:
                groups.setdefault(type(record), []).append(record)
            self._by_type.update({key: tuple(group) for key, group in groups.items()})
        return cast("tuple[R, ...]", self._by_type.get(kind, ()))


def read_log(source: str | Path | Iterable[str | bytes], *, name: str | None = None, report: bool = True) -> Log:
    """Read a file (a path) or the lines of an open one (any iterable of lines).

    What cannot be read is logged as a warning, once for each kind, unless ``report`` is False: then the caller calls
    `report_problems` when he has seen that the log is of use. A text without any sentence gives a log without
    records (``log.sentences`` is 0).

    Raises
    ------
    InputError : no such file, a directory, not readable, empty, or a binary file that holds no sentence
    """
    if isinstance(source, str | Path):
        path = Path(source)
        name = name or path.name
        lines: list[str | bytes] = list(_file_lines(path))
    else:
        name = name or "log"
        lines = list(source)
    log = _read(lines, name)
    _require_text(log)
    if report:
        report_problems(log)
    return log


def report_problems(log: Log) -> None:
    """Log what could not be read as warnings, once for each kind."""
    for problem in log.problems:
        _logger.warning("%s: %s", log.name, problem)


def _read(lines: list[str | bytes], name: str) -> Log:
    reader = Reader(start_s=_start_s(lines))
    feed = reader.feed
    records = tuple(chain.from_iterable(feed(line) for line in lines))
    reader.close()
    counts = MappingProxyType(dict(reader.counts))
    return Log(name, records, counts, reader.problems, reader.lines, reader.time_basis)


def _file_lines(path: Path) -> list[bytes]:
    if path.is_dir():
        raise InputError(f"{path}: is a directory, expected a log file with NMEA sentences", source=str(path))
    try:
        return path.read_bytes().splitlines()
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file", source=str(path)) from error
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}", source=str(path)) from error


def _require_text(log: Log) -> None:
    if log.sentences:
        return
    kinds = {problem.kind for problem in log.problems}
    if "binary" in kinds:
        raise InputError(f"{log.name}: a binary file, nothing in it is NMEA", source=log.name)
    if not kinds:
        raise InputError(f"{log.name}: is empty, expected NMEA sentences ($..., !AIVDM...)", source=log.name)


def _start_s(lines: list[str | bytes]) -> float | None:
    """Return date and time of the first timed sentence, its date from the first that tells one; None with stamps."""
    first_of_day_s = None
    for told in _times_told(lines):
        if told is None:
            return None
        _, utc_s, dated = told
        if not dated:
            first_of_day_s = utc_s if first_of_day_s is None else first_of_day_s
        elif first_of_day_s is None:
            return utc_s
        else:
            return first_of_day_s + DAY_S * round((utc_s - first_of_day_s) / DAY_S)
    return None


def _times_told(lines: list[str | bytes]) -> Iterator[tuple[int, float, bool] | None]:
    """Yield what the sentences tell of the time; None for a line that has a time of its own."""
    for line in lines:
        text = as_text(line)
        if not any(mark in text for mark in _TIMED):
            continue
        try:
            found = frame(text)
        except Unreadable:
            continue
        if found is not None and found.time_s is not None:
            yield None
        elif found is not None and (told := sentences.sentence_time(found)) is not None:
            yield told
