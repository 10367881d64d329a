"""The command ``navfix``: results on stdout, log on stderr, exit codes as in `navfix.cli.errors`."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import logging
import os
import sys
import traceback
from collections.abc import Iterator, Sequence

from navfix import __version__
from navfix.cli import outputs
from navfix.cli.errors import INTERRUPTED, OK, USAGE, outcome

COMMANDS = ("demo", "fix", "compare", "adjust", "replay", "targets", "simulate", "chart", "models")

_DESCRIPTION = """\
Own-ship position and heading from what radar and AIS see, without own GNSS.

exit codes: 0 at least one fix, 2 usage, 3 no fix, 4 nothing readable"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: 0 done, 2 usage, 3 no fix, 4 nothing readable; never a traceback."""
    # One thread is the fastest at these matrix sizes; numpy reads this when it is first imported, later than here.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    _never_fail_on_a_character()
    try:
        args = parser().parse_args(argv)
    except SystemExit as stop:  # --help, --version or a usage error, already printed by argparse
        return stop.code if isinstance(stop.code, int) else USAGE
    with _logging_to_stderr(args.verbose):
        return _run(args)


def parser() -> argparse.ArgumentParser:
    """Return the parser of all commands; each command's module adds its own."""
    top = argparse.ArgumentParser(
        prog="navfix",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    top.add_argument("--version", action="version", version=f"navfix {__version__}")
    top.add_argument("-v", "--verbose", action="count", default=0, help="say more on stderr; -vv for everything")
    commands = top.add_subparsers(metavar="COMMAND", required=True)
    for name in COMMANDS:
        importlib.import_module(f"navfix.cli.{name}").add_parser(commands)
    for command in commands.choices.values():
        command.allow_abbrev = False
        command.description = (command.description or "").replace("``", "")  # the docstring of its module
        command.add_argument("-v", "--verbose", action="count", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
    return top


def _run(args: argparse.Namespace) -> int:
    """Run the command of ``args`` and turn every way to end into an exit code and at most one line on stderr."""
    try:
        outputs.protect_inputs(args)
        code = int(args.run(args))
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of our output has seen enough: no error
        _discard_stdout()
        return OK
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:  # noqa: BLE001 - the boundary: the user gets one line, -vv the traceback
        code, line = outcome(error)
        print(f"navfix: {line}", file=sys.stderr)
        if args.verbose > 1:
            traceback.print_exc()
    return code


@contextlib.contextmanager
def _logging_to_stderr(verbosity: int) -> Iterator[None]:
    """Send the log of the package to stderr while a command runs: warnings, with -v information, with -vv all."""
    logger, handler = logging.getLogger("navfix"), logging.StreamHandler()
    handler.setFormatter(logging.Formatter("navfix: %(message)s"))
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel((logging.WARNING, logging.INFO, logging.DEBUG)[min(verbosity, 2)])
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


def _never_fail_on_a_character() -> None:
    """Print a question mark where a terminal without UTF-8 has no degree sign, in place of an exception."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")


def _discard_stdout() -> None:
    """Point stdout at nothing, so that the interpreter's own flush at the end does not fail again."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
