"""The options of a server, and its start: address, QR code, certificate."""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import note

if TYPE_CHECKING:
    from starlette.routing import BaseRoute

    from overview_dsp.web.control import Session

NEEDED = ("starlette", "uvicorn", "websockets", "cryptography", "segno")
_NAMES = ("host", "port", "cert", "key", "token_file")


def server_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Where a server listens, for `open_server`; the command gets them as `server`."""

    @functools.wraps(function)
    def collected(*arguments: Any, **named: Any) -> Any:
        server = {name: named.pop(name) for name in _NAMES}
        return function(*arguments, server=server, **named)

    options = (
        click.option("--host", default="127.0.0.1", show_default=True,
                     help="Where the server listens; 0.0.0.0 for a phone in the network."),
        click.option("--port", default=8765, show_default=True, type=click.IntRange(0, 65535),
                     help="Its port, 0 for a free one."),
        click.option("--cert", metavar="FILE.pem", help="A certificate in place of its own."),
        click.option("--key", metavar="FILE.pem", help="The key of --cert, if in another file."),
        click.option("--token-file", metavar="FILE",
                     help="Keep the address's token there: pages connect again after a restart."),
    )  # fmt: skip
    for option in reversed(options):
        collected = option(collected)
    return collected


def require_server() -> None:
    """InputError, with how to install it, if a package that a server needs is missing."""
    from overview_dsp.errors import InputError

    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        raise InputError(f"the page needs {', '.join(missing)}: pip install 'overview-dsp[web]'")


def refuse_given(names: Collection[str], why: str) -> None:
    """InputError if an option was given that has no effect here."""
    from click.core import ParameterSource

    from overview_dsp.errors import InputError

    context = click.get_current_context()
    for name in names:
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise InputError(f"--{name.replace('_', '-')} {why}")


def refuse_server_options() -> None:
    """InputError if a server's options were given where there is none."""
    refuse_given(_NAMES, "is for the server that --remote opens; give that too")


@dataclass(frozen=True)
class Opened:
    """Where a server is: `address` holds the token, `qr` is it as a picture for phones."""

    address: str
    fingerprint_sha256: str | None
    qr: str | None

    @property
    def text(self) -> str:
        """For a person: the address first."""
        lines = [f"open {self.address}"]
        if self.fingerprint_sha256 is not None:
            lines.append(f"certificate SHA-256 {self.fingerprint_sha256}")
        if self.qr is not None:
            lines.append(self.qr.rstrip("\n"))
        return "\n".join(lines)


@contextmanager
def open_server(
    server: dict[str, Any],
    session: Session | None = None,
    more: Collection[BaseRoute] = (),
    crowd: bool = False,
    public: Collection[str] | None = None,
) -> Iterator[Opened]:
    """Serve the page (and a session's `/control`, and more routes) meanwhile; where it is.

    `crowd`: to hundreds of pages; `public`: as in `make_app`.

    The address goes to standard error, with a QR code where a phone can reach it.

    Raises
    ------
    InputError
        The address or the certificate can't be used.
    """
    from overview_dsp.errors import InputError
    from overview_dsp.web import server as address
    from overview_dsp.web.app import make_app
    from overview_dsp.web.certificate import fingerprint, own_certificate, secure_context
    from overview_dsp.web.security.auth_token import Access, kept_token
    from overview_dsp.web.server import WebServer, listen

    host, port, cert, key, kept = (server[name] for name in _NAMES)
    near = address.is_loopback(host)
    reached = address.reached_at(host)
    if key is not None and cert is None:
        raise InputError("--key belongs to a --cert; give both")
    secure, certificate = None, None
    if cert is not None:
        certificate = Path(cert)
    elif not near:
        own = sorted(address.own_names())
        certificate = own_certificate([reached, "localhost", "127.0.0.1", "::1", *own])
    if certificate is not None:
        secure = secure_context(certificate, None if key is None else Path(key))
    names = address.own_names() | ({host.lower()} if reached == host else set())
    access = Access() if kept is None else Access(token=kept_token(kept))
    app = make_app(access, names, note, session, more, public)
    socket = listen(host, port)
    scheme = "http" if secure is None else "https"
    where = address.page_address(scheme, reached, socket.getsockname()[1], access.token)
    running = WebServer(app, [socket], secure, note, crowd)
    try:
        opened = Opened(
            where,
            None if certificate is None else fingerprint(certificate),
            None if near else address.qr_text(where),
        )
        click.echo(opened.text, err=True)
        yield opened
    finally:
        running.close()
