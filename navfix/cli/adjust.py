"""``navfix adjust``: cases written by hand, adjusted as a textbook does, classical and robust side by side."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from navfix.cli import options, outputs, values
from navfix.cli.errors import OK, outcome

if TYPE_CHECKING:
    from navfix.adjustment.case import Case
    from navfix.adjustment.textbook import LinearStep
    from navfix.errors import NoFix
    from navfix.kernels import Kernel
    from navfix.types import Fix

SUFFIXES = (".txt", ".json", ".html")
SIDE_BY_SIDE = ("none", "huber", "hampel", "danish")


@dataclass(frozen=True, slots=True)
class Result:
    """What one case gave: exit code, a line for stderr, and its report as text, JSON object and HTML section.

    Each report is made when it is asked for: the textbook's matrices have as many rows as there are observations.
    """

    text: Callable[[], str]
    content: Callable[[], Mapping[str, Any]]
    section: Callable[[], str]
    code: int = OK
    complaint: str = ""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser("adjust", help="adjust a case file: the textbook report", description=__doc__)
    parser.add_argument("case", metavar="CASE", nargs="+", help="case file, TOML or JSON; - reads stdin")
    options.add_kernel(parser)
    parser.add_argument(
        "--damping",
        choices=("joint", "separate"),
        default="joint",
        help="damp what was measured to one target together, or each observation by itself (default: joint)",
    )
    parser.add_argument(
        "--standardise",
        choices=("sigma", "gdynia"),
        default="sigma",
        help="the kernel acts on residuals in units of the observation's sigma, or of the residual's own a-priori one "
        "(gdynia; default: sigma)",
    )
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Adjust every case and print one report, or one line of JSON, for each."""
    from navfix.report.case_html import cases_html
    from navfix.report.json_parts import to_json_line

    kernel = options.kernel(args)
    manner = {"damping": args.damping, "standardise": args.standardise}
    results = [_solved(name, kernel, manner) for name in args.case]
    for result in results:
        if result.complaint:
            print(f"navfix: {result.complaint}", file=sys.stderr)
    writers = {
        ".txt": lambda: "\n".join(text for result in results if (text := result.text())),
        ".json": lambda: "".join(f"{to_json_line(result.content())}\n" for result in results),
        ".html": lambda: cases_html([result.section() for result in results], "navfix: adjustment"),
    }
    print(writers[".json" if args.json else ".txt"](), end="")
    outputs.write_outputs(args.out, writers)
    return min(result.code for result in results)  # one fix is enough for 0, one readable case for 3


def _solved(name: str, kernel: Kernel, manner: Mapping[str, Any]) -> Result:
    """Read and adjust one case; what goes wrong with it does not stop the others."""
    from navfix.adjustment.case import parse_case
    from navfix.errors import InputError, NoFix

    try:
        case = parse_case(_text(name), source="stdin" if name == values.STDIN else name)
    except (InputError, OSError, UnicodeDecodeError) as error:
        code, complaint = outcome(error)
        return _refused(name, "unreadable", complaint, code, complaint)
    try:
        return _adjusted(case, kernel, manner)
    except NoFix as error:
        code, complaint = outcome(error)
        return _refused(case.name, error.reason, str(error), code, f"{name}: {complaint}", error)


def _refused(case: str, reason: str, message: str, code: int, complaint: str, error: NoFix | None = None) -> Result:
    from navfix.report.case_html import refused_html

    return Result(
        text=lambda: "",
        content=lambda: _nothing(case, reason, message, error),
        section=lambda: refused_html(case, message),
        code=code,
        complaint=complaint,
    )


def _text(name: str) -> str:
    if name == values.STDIN:
        return sys.stdin.read()
    try:
        return Path(name).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        from navfix.errors import InputError

        raise InputError(f"{name}: not text; expected a case file, TOML or JSON", source=name) from error


def _adjusted(case: Case, kernel: Kernel, manner: Mapping[str, Any]) -> Result:
    from navfix.adjustment.adjust_case import adjust_case, first_step
    from navfix.errors import NoFix
    from navfix.report.case_html import case_html
    from navfix.report.case_text import case_report

    fix = adjust_case(case, kernel=kernel, **manner)
    step = first_step(case, fix)
    others: dict[str, Fix | NoFix] = {}
    for name in SIDE_BY_SIDE:
        try:
            others[name] = fix if name == kernel.name else adjust_case(case, kernel=name, **manner)
        except NoFix as error:
            others[name] = error
    others.setdefault(kernel.name, fix)
    return Result(
        text=lambda: case_report(case, step, fix, others),
        content=lambda: _content(case, fix, step),
        section=lambda: case_html(case, step, fix, others),
    )


def _content(case: Case, fix: Fix, step: LinearStep | None) -> dict[str, Any]:
    """Return the object of a fix with the textbook's matrices, `null` where the first step is singular."""
    from navfix.report.case_json import textbook_to_dict, utm_to_dict
    from navfix.report.fix_json import fix_to_dict

    return fix_to_dict(fix) | {"case": case.name, "utm": utm_to_dict(case, fix)} | textbook_to_dict(step)


def _nothing(name: str, reason: str, message: str, error: NoFix | None = None) -> dict[str, Any]:
    from navfix.report.case_json import textbook_to_dict
    from navfix.report.fix_json import no_fix_to_dict

    return (
        no_fix_to_dict(error)
        | {"reason": reason, "message": message, "case": name, "utm": None}
        | textbook_to_dict(None)
    )
