"""How a command ends: the exit codes, and the one line on stderr that belongs to each."""

from __future__ import annotations

from navfix.errors import CatalogError, InputError, NoFix

OK = 0  # at least one fix, or the command has no fix to make and did its work
INTERNAL = 1  # a fault of navfix itself
USAGE = 2  # the command line cannot be right, or a result cannot be written
NO_FIX = 3  # the data are readable, no fix follows (also: without AIS, or without radar)
UNREADABLE = 4  # nothing readable: a missing file, a directory, a binary file
INTERRUPTED = 130  # Ctrl-C, as shells count it


class CommandError(Exception):
    """End the command with ``code`` and one line on stderr.

    For what only the command can know: a usage error that argparse cannot see, or a log that reads well and holds
    nothing to work with. Errors of the library need no wrapping: `outcome` knows their codes.
    """

    def __init__(self, message: str, code: int = USAGE) -> None:
        super().__init__(message)
        self.code = code


def outcome(error: Exception) -> tuple[int, str]:
    """Return the exit code and the line for stderr that an exception stands for."""
    if isinstance(error, CommandError):
        return error.code, one_line(error)
    if isinstance(error, NoFix):
        return NO_FIX, f"no fix ({error.reason}): {one_line(error)}"
    if isinstance(error, CatalogError):
        return USAGE, one_line(error)
    if isinstance(error, InputError):
        return UNREADABLE, f"{_place(error)}{one_line(error)}"
    if isinstance(error, OSError):
        return UNREADABLE, _os_error(error)
    if isinstance(error, UnicodeDecodeError):
        return UNREADABLE, "the file is not text; expected NMEA sentences, CSV, JSON or TOML"
    return INTERNAL, f"internal error, {type(error).__name__}: {one_line(error)} (-vv shows where)"


def one_line(error: BaseException) -> str:
    """Return the message of an exception without line breaks."""
    return " ".join(str(error).split()) or type(error).__name__


def _place(error: InputError) -> str:
    """Return "source:line: " as far as the error knows it and its message does not say it already."""
    if not error.source or str(error.source) in str(error):
        return ""
    return f"{error.source}:{error.line}: " if error.line is not None else f"{error.source}: "


def _os_error(error: OSError) -> str:
    name = error.filename if error.filename is not None else "input"
    match error:
        case FileNotFoundError():
            return f"{name}: no such file"
        case IsADirectoryError():
            return f"{name}: is a directory; expected a file"
        case _:
            return f"{name}: {error.strerror or one_line(error)}"
