"""The fused list over time: keeps the newest of each ship, looks ships up, and tells those who watch."""

from __future__ import annotations

from collections.abc import Callable

from navfix.types import TargetList, TrackedShip

Watcher = Callable[[TargetList], None]


class TargetBoard:
    """Holds the newest list of ships; views and controllers ask it or are told by it."""

    def __init__(self) -> None:
        self._newest: TargetList | None = None
        self._watchers: list[Watcher] = []

    @property
    def newest(self) -> TargetList | None:
        """The newest list, None before the first."""
        return self._newest

    def update(self, ships: TargetList) -> None:
        """Take a new list in and tell every watcher, in the order in which they came."""
        self._newest = ships
        for watcher in tuple(self._watchers):
            watcher(ships)

    def watch(self, watcher: Watcher) -> Callable[[], None]:
        """Call ``watcher`` with every new list; return what ends that (twice does no harm)."""
        self._watchers.append(watcher)

        def stop() -> None:
            if watcher in self._watchers:
                self._watchers.remove(watcher)

        return stop

    def find(self, key: str | int) -> tuple[TrackedShip, ...]:
        """Return the ships that a target's label (07 or 7), an MMSI or a part of a name stands for."""
        if self._newest is None:
            return ()
        return tuple(ship for ship in self._newest.ships if _answers_to(ship, str(key).strip().upper()))


def _answers_to(ship: TrackedShip, key: str) -> bool:
    if not key:
        return False
    number = str(int(key)) if key.isdecimal() else key
    labels = {str(ship.mmsi), ship.mark, ship.target, (ship.target or "").lstrip("0")}
    return key in labels or number in labels or (not key.isdecimal() and key in (ship.name or "").upper())
