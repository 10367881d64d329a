"""``navfix models``: what is in the catalogue, with the source of each model."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Iterable
from typing import Any

from navfix.cli import options, outputs
from navfix.cli.errors import OK

SUFFIXES = (".txt", ".json")
Entry = tuple[str, str, dict[str, Any]]  # kind, name, table


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser("models", help="what is in the catalogue, with sources", description=__doc__)
    parser.add_argument("name", metavar="NAME", nargs="?", help="one model (imo), one kind (radar) or both (radar/imo)")
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the catalogue, or the part of it that has the name."""
    entries = select(args.name)
    text = in_full(entries) if args.name else overview(entries)
    as_json = json.dumps([{"kind": kind, "name": name, **content} for kind, name, content in entries], indent=2)
    print(as_json if args.json else text)
    outputs.write_outputs(args.out, {".txt": lambda: text + "\n", ".json": lambda: as_json + "\n"})
    return OK


def select(wanted: str | None) -> list[Entry]:
    """Return the entries of the catalogue whose name, kind or kind/name is ``wanted``; all of them for None.

    Raises
    ------
    CatalogError : nothing has this name
    """
    from navfix import catalog
    from navfix.errors import CatalogError

    everything = list(catalog.every_table())
    found = [entry for entry in everything if wanted in (None, entry[0], entry[1], f"{entry[0]}/{entry[1]}")]
    if not found:
        known = ", ".join(f"{kind}/{name}" for kind, name, _ in everything)
        raise CatalogError(f"no model or kind named {wanted!r}; there are {known}", key=wanted)
    return found


def overview(entries: Iterable[Entry]) -> str:
    """Return the catalogue as text: one line for the model, its source below."""
    lines: list[str] = []
    last_kind = ""
    for kind, name, content in entries:
        if kind != last_kind:
            lines += ["", kind] if lines else [kind]
            last_kind = kind
        lines.append(f"  {name:<16} {content['title']}")
        lines += _wrapped(f"source: {content['source']}", indent=19)
    return "\n".join(lines)


def in_full(entries: Iterable[Entry]) -> str:
    """Return the entries as text with every value."""
    blocks = []
    for kind, name, content in entries:
        values = {key: value for key, value in content.items() if key not in ("title", "source")}
        width = max((len(key) for key in values), default=0)
        lines = [f"{kind}/{name}: {content['title']}"]
        lines += [f"  {key:<{width}} = {json.dumps(value)}" for key, value in values.items()]
        blocks.append("\n".join(lines + _wrapped(f"source: {content['source']}", indent=2)))
    return "\n\n".join(blocks)


def _wrapped(text: str, *, indent: int) -> list[str]:
    blank = " " * indent
    return textwrap.wrap(text, width=100, initial_indent=blank, subsequent_indent=blank + "  ")
