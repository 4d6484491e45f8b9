"""Hints for files of an unknown format: the most similar format, and what is missing for it."""

from __future__ import annotations

import contextlib
import re

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.cells import looks_numeric
from overview_dsp.data.readers.tables.column_roles import (
    is_wordy,
    kind_and_label_columns,
    named_time_column,
)
from overview_dsp.data.readers.tables.delimited import DelimitedTable
from overview_dsp.data.readers.tables.dialect import detect
from overview_dsp.data.readers.tables.json import is_single, tables_in
from overview_dsp.data.readers.tables.logs import is_log
from overview_dsp.data.readers.tables.table import Columns, Head, listed
from overview_dsp.data.readers.tables.time_column import detected_format
from overview_dsp.errors import InputError, quoted

_PACKED = {
    b"PK\x03\x04": "a spreadsheet or an archive: save the sheet as CSV",
    b"\xd0\xcf\x11\xe0": "an old spreadsheet: save the sheet as CSV",
    b"SQLite format 3": "a database: write one table as CSV",
    b"%PDF": "a PDF: copy its table into a CSV file",
    b"\x89PNG": "a picture: give the data it shows, as CSV",
    b"\xff\xd8\xff": "a picture: give the data it shows, as CSV",
}
_AS_EVENTS = "write the events as CSV with the columns time and event"
_XML = "<?xml"

_PAGE = re.compile(r"<!doctype html|<html\b|^\s*<(?:head|body)\b", re.I)
_LOGIN = re.compile(r"type\s*=\s*[\"']?password", re.I)
_FEED = re.compile(r"<(?:rss|feed|rdf:rdf)\b", re.I)
_LYRICS = re.compile(r"\[(?:ti|ar|al|au|by|re|ve|offset|length):|\[\d{1,3}:\d\d\.\d{2,3}\]", re.I)
_FIRST = 1000
"""Number of characters in which the root element of XML begins, after comments."""
_EVENT_LIST = "nearest: a table of events"


def require_no_other_document(source: DataFile) -> None:
    """Raise InputError for a web page, a login page, a news feed, lyrics and a blank file.

    A reader of text would take them for a table or for broken JSON.
    """
    if source.head_text is None:
        return
    text = source.head_text.lstrip("\ufeff \r\n\t")
    begin = text[:_FIRST]
    what = None
    if not text and source.size <= len(source.head):
        what = "holds blanks only; check how it was made, or get it again"
    elif begin.startswith("<") and _FEED.search(begin):
        what = f"is a news feed (RSS or Atom), not a timeline; {_AS_EVENTS}"
    elif begin.startswith("<") and _PAGE.search(begin):
        what = "is a web page; save the file it links to, or its table as CSV"
        if _LOGIN.search(text):
            what = "is a login page; sign in with a browser and save the file itself"
    elif _LYRICS.match(begin):
        what = "holds lyrics (LRC); write their lines as CSV with the columns time and label"
    if what is not None:
        raise InputError(f"{source.where}: {what}")


def format_hint(source: DataFile) -> str:
    """Return a hint with the most similar format and the missing column."""
    head = source.head
    for mark, words in _PACKED.items():
        if head.startswith(mark):
            return words
    text = source.head_text
    if text is None:
        return "nearest: text (CSV, JSON), a recording, or a WFDB record"
    if text.lstrip("\ufeff \r\n\t").lower().startswith(_XML):
        return f"XML: {_AS_EVENTS}"
    if is_log(source):
        return "nearest: a log; its lines are counted with map='count' (--map count)"
    found = _json_table(source) if source.looks_like_json else _text_table(source)
    if found is None:
        shape = (
            "a list of records with time and event"
            if source.looks_like_json
            else ("a first row that names the columns, such as time,event")
        )
        return f"{_EVENT_LIST}; it lacks {shape}"
    return _lacking(*found)


def _text_table(source: DataFile) -> tuple[Columns, list[list[object]]] | None:
    layout = detect(source, lambda header, below: bool(below))
    if layout is None or layout.separator is None:  # text without columns
        return None
    table = DelimitedTable(source, layout)
    with contextlib.suppress(InputError):  # for example broken quotes
        for chunk in table.chunks(range(len(table.columns))):
            return table.columns, [list(cells[:50]) for cells in chunk.cells]
    return None


def _json_table(source: DataFile) -> tuple[Columns, list[list[object]]] | None:
    tables = list(tables_in(source.json))
    if not tables:
        return None
    table = max(tables, key=lambda one: one.rows)
    cells = [table.cut(i, 0, 50) for i in range(len(table.columns))]
    head = [[cell if is_single(cell) else str(cell) for cell in column] for column in cells]
    return table.columns, head


def _lacking(columns: Columns, head: Head) -> str:
    """Return which column is missing for a series, or for a table of events."""
    there = f"its columns are {listed(columns)}"
    named = named_time_column(columns)
    timed = named
    for i, column in enumerate(columns):
        if timed is None and head[i] and not looks_numeric(head[i]):
            timed = i if detected_format(column, head[i]) is not None else None
    numbers = [i for i in range(len(columns)) if i != timed and looks_numeric(head[i])]
    words = [i for i in range(len(columns)) if i != timed and is_wordy(head[i])]
    kind, label = kind_and_label_columns(columns)
    if timed is None:
        if words:
            return f"{_EVENT_LIST}; no column is called time, date, start or minute: {there}"
        return f"nearest: a series; no column is called time or date: {there}"
    if numbers and not words:
        return f"nearest: a series; no column except {_column(columns, timed)} has values: {there}"
    if kind is None and label is None and words:
        return (
            f"{_EVENT_LIST}; no column is called event, what, type, kind, name or label: rename "
            f"{_column(columns, words[0])}"
        )
    if not words:
        return f"{_EVENT_LIST}; no column of kinds or labels (event, what, type, name): {there}"
    if named is None:
        return f"{_EVENT_LIST}; call {_column(columns, timed)} time"
    return f"{_EVENT_LIST}; {_column(columns, timed)} has no known format of times: {there}"


def _column(columns: Columns, i: int) -> str:
    return f"column {quoted(columns[i].header)}"
