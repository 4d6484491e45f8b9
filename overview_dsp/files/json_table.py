"""JSON files of the user: a table of settings by name, which the user may edit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import make_folder, write_file


def read_table(path: Path, requirement: str) -> dict[str, Any]:
    """Read a table, empty without a file; an InputError for another content has `requirement`."""
    try:
        table = json.loads(path.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: can't be read ({error}); correct or delete it") from None
    if not isinstance(table, dict):
        raise InputError(f"{path}: {requirement}; correct or delete it")
    return table


def write_table(path: Path, table: dict[str, Any]) -> None:
    """Write a table, and make its folder; InputError or OutputError if that fails."""
    make_folder(path.parent)
    write_file(path, json.dumps(table, indent=1, ensure_ascii=False))
