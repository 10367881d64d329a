"""Lives of tracks: one target number may be many echoes over minutes; each gets an identity that lasts over windows."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.association.window.joint import Window


@dataclass(slots=True)
class _Life:
    number: int
    first_s: float
    last_s: float
    range_m: float


class Lives:
    """Knows every echo of the last minutes by a number that is never used again."""

    def __init__(self, memory_s: float) -> None:
        self._memory_s = memory_s
        self._by_label: dict[str, list[_Life]] = {}
        self._next = 0

    @property
    def known(self) -> set[int]:
        """All lives that are remembered."""
        return {life.number for lives in self._by_label.values() for life in lives}

    def note(self, window: Window, now_s: float) -> None:
        """Take a window in: its tracks continue lives or begin new ones; what was not seen for long is forgotten."""
        self.of(window)
        for label, lives in list(self._by_label.items()):
            kept = [life for life in lives if now_s - life.last_s <= self._memory_s]
            if kept:
                self._by_label[label] = kept
            else:
                del self._by_label[label]

    def of(self, window: Window) -> list[int]:
        """Return the life of every track of a window."""
        model = window.field.model
        numbers = [0] * len(window.field.scene.tracks)
        ordered = sorted(range(len(numbers)), key=lambda i: window.field.scene.tracks[i].time_s[0])
        taken: set[int] = set()
        for i in ordered:
            track = window.field.scene.tracks[i]
            first_s, last_s, range_m = float(track.time_s[0]), float(track.time_s[-1]), float(abs(track.rho[-1]))
            lives = self._by_label.setdefault(track.label, [])
            life = next(
                (x for x in reversed(lives) if x.number not in taken and first_s <= x.last_s and last_s >= x.first_s),
                None,
            )
            if life is None and lives and lives[-1].number not in taken:
                newest = lives[-1]
                follows = 0.0 < first_s - newest.last_s <= model.gap_s
                if follows and abs(float(abs(track.rho[0])) - newest.range_m) <= model.jump_m:
                    life = newest
            if life is None:
                life = _Life(self._next, first_s, last_s, range_m)
                self._next += 1
                lives.append(life)
            taken.add(life.number)
            if last_s >= life.last_s:
                life.last_s, life.range_m = last_s, range_m
            life.first_s = min(life.first_s, first_s)
            numbers[i] = life.number
        return numbers
