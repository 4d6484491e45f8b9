"""The export of Apple Health (export.zip, export.xml) as CSV: time, metric, source and value."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator
from typing import NoReturn
from xml.parsers import expat

from overview_dsp.errors import InputError

_ROOT = b"<HealthData"
_MEMBER = re.compile(r"apple_health_export/[^/]+(?<!_cda)\.xml")
_TYPE = re.compile(r"HK\w*?TypeIdentifier")
_LONGEST = 200
_PART = 1 << 16
_NUMBER = re.compile(r"-?[0-9.]+(?:e-?[0-9]+)?", re.I)


def is_export(head: bytes) -> bool:
    """Return whether XML has the root element of an export, within its first bytes."""
    return _ROOT in head and head.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"<")


def member(names: Iterable[str]) -> str | None:
    """Return the file with the records in the archive of an export; None in other archives."""
    return next((name for name in names if _MEMBER.fullmatch(name)), None)


def csv_parts(xml: Iterable[bytes], where: str) -> Iterator[bytes]:
    """Yield the records with numbers as CSV; InputError for broken XML or no such record."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    count = 0

    def start(tag: str, has: dict[str, str]) -> None:
        nonlocal count
        if tag == "Record" and _NUMBER.fullmatch(has.get("value", "")) and "startDate" in has:
            metric = _TYPE.sub("", has.get("type", "")[:_LONGEST])
            unit = has.get("unit", "")[:_LONGEST]
            source = has.get("sourceName", "")[:_LONGEST]
            writer.writerow((has["startDate"], f"{metric} ({unit})", source, has["value"]))
            count += 1

    def refuse(*_: object) -> NoReturn:
        raise InputError(
            f"{where}: XML with entities or default values, unlike an export of Apple Health"
        )

    def attribute(tag: str, name: str, kind: str, default: str | None, required: bool) -> None:
        if default is not None:  # a default would be copied into each record
            refuse()

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EntityDeclHandler = start, refuse
    parser.AttlistDeclHandler = attribute
    yield b"time,metric,source,value\n"
    try:
        for part in (one[i : i + _PART] for one in xml for i in range(0, len(one), _PART)):
            parser.Parse(part, False)
            yield text.getvalue().encode()
            text.seek(0)
            text.truncate()
        parser.Parse(b"", True)
    except expat.ExpatError as error:
        raise InputError(f"{where}: broken XML ({error}); export the data again") from error
    yield text.getvalue().encode()
    if not count:
        raise InputError(f"{where}: the export has no records with numbers")
