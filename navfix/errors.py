"""The exception tree.

::

    NavfixError
    |- InputError(ValueError)   a sentence, file or value that cannot be right
    |- CatalogError(KeyError)   an unknown model name, an unknown or missing key
    `- NoFix                    the data are fine, no fix follows: a normal state at sea
       |- TooFewPairs           fewer observations than unknowns
       |- Unobservable          the geometry leaves a direction free
       |- NoAgreement           nothing explains the data better than chance
       `- Ambiguous             another place explains the data nearly as well
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class NavfixError(Exception):
    """Every error that navfix raises on purpose."""


class InputError(NavfixError, ValueError):
    """Input that cannot be right; the message says what was seen, what was expected and what to do.

    Attributes
    ----------
    source : name of the file or record, None where there is none
    line : line number, counted from 1, None where there is none
    """

    def __init__(self, message: str, *, source: str | None = None, line: int | None = None) -> None:
        super().__init__(message)
        self.source = source
        self.line = line


class CatalogError(NavfixError, KeyError):
    """An unknown model name, or an unknown or missing key in a model file.

    Attributes
    ----------
    path : the model file, None where the name itself is unknown
    key : the key or name that is wrong
    """

    def __init__(self, message: str, *, path: str | None = None, key: str | None = None) -> None:
        super().__init__(message)
        self.path = path
        self.key = key

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError would print the repr


class NoFix(NavfixError):
    """The data are fine and no fix follows from them; ``reason`` is the word that the JSON record carries."""

    reason = "no_fix"


class TooFewPairs(NoFix):
    """Fewer observations than unknowns, or fewer targets or marks than an association needs."""

    reason = "too_few_pairs"

    def __init__(self, message: str, *, observations: int, unknowns: int) -> None:
        super().__init__(message)
        self.observations = observations
        self.unknowns = unknowns


class Unobservable(NoFix):
    """The geometry leaves a direction of the unknowns free.

    Attributes
    ----------
    direction : unit vector in (north m, east m, heading rad) that the data do not determine, or its description
    """

    reason = "unobservable"

    def __init__(self, message: str, *, direction: Sequence[float] | str) -> None:
        super().__init__(message)
        self.direction = direction


class NoAgreement(NoFix):
    """Nothing explains the data better than chance.

    Attributes
    ----------
    evidence : log evidence of the best place found (natural logarithm)
    alternatives : the places tried, best first (records ``navfix.types.Alternative``)
    """

    reason = "no_agreement"

    def __init__(self, message: str, *, evidence: float, alternatives: Sequence[Any] = ()) -> None:
        super().__init__(message)
        self.evidence = evidence
        self.alternatives = tuple(alternatives)


class Ambiguous(NoFix):
    """Another place explains the data nearly as well.

    Attributes
    ----------
    alternatives : every solution, best first, none cut off (records ``navfix.types.Alternative``)
    """

    reason = "ambiguous"

    def __init__(self, message: str, *, alternatives: Sequence[Any]) -> None:
        super().__init__(message)
        self.alternatives = tuple(alternatives)
