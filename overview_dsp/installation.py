"""Optional packages, and the commands that install them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

from overview_dsp.errors import InputError

DISTRIBUTION = "overview-dsp"


def install_command(extra: str) -> str:
    """Return the pip command that installs an extra of this package.

    The package is in no registry. So pip gets the source tree that it runs from, or the folder or
    wheel that it was installed from: `.` if that is the working folder.
    """
    source = _source()
    if source is None:
        return f"pip install '.[{extra}]' in a clone of the project"
    target = "." if source == Path.cwd() else str(source)
    return f"pip install '{target}[{extra}]'"


def require_package(module: str, purpose: str, extra: str) -> Any:
    """Import a module of an optional package for a `purpose`; InputError names its `extra`."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        command = install_command(extra)
        raise InputError(
            f"{purpose} needs the package {package} ({error}); install it: {command}"
        ) from error


def require_library(module: str, what: str, extra: str, otherwise: str) -> Any:
    """Import a module of an optional library; InputError names its `extra` and another remedy."""
    try:
        return import_module(module)
    except ImportError as error:
        package, command = module.partition(".")[0], install_command(extra)
        raise InputError(f"{what} needs {package}: {command}, or {otherwise}") from error


@contextmanager
def library_errors(message: Callable[[Exception], str]) -> Iterator[None]:
    """Turn any error of a library, which are rarely documented, into an InputError."""
    try:
        yield
    except InputError:  # a ValueError too
        raise
    except Exception as error:
        raise InputError(message(error)) from error


def _source() -> Path | None:
    """Return the folder or wheel of this installation; None if it is gone or unknown."""
    tree = Path(__file__).resolve().parent.parent
    if (tree / "pyproject.toml").is_file():
        return tree
    from importlib import metadata

    try:
        record = metadata.distribution(DISTRIBUTION).read_text("direct_url.json")
        path = Path(url2pathname(urlsplit(json.loads(record or "{}")["url"]).path))
    except (metadata.PackageNotFoundError, KeyError, ValueError):
        return None
    return path if (path / "pyproject.toml").is_file() or path.suffix == ".whl" else None
