"""Options and start of a server: address, QR code, certificate."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import click

from overview_dsp.cli.common import note
from overview_dsp.cli.options.declaring import option
from overview_dsp.errors import InputError
from overview_dsp.installation import install_command

if TYPE_CHECKING:
    from starlette.routing import BaseRoute

    from overview_dsp.web.session import HostSession

NEEDED = ("starlette", "uvicorn", "websockets", "cryptography", "segno")
HOST, PORT = "127.0.0.1", 8765


@dataclass(frozen=True)
class Server:
    """Options of the address and the security of a server."""

    heading: ClassVar[str] = "Server"

    host: str = option(default=HOST)
    port: int = option(default=PORT, type=click.IntRange(0, 65535))
    cert: str | None = option(metavar="FILE.pem")
    key: str | None = option(metavar="FILE.pem")
    token_file: str | None = option(metavar="FILE")


def server_at(text: str) -> Server:
    """Parse `[HOST][:PORT]`; "" is the default server; InputError."""
    found = re.fullmatch(r"(\[[^\]]+\]|[^:\s]*)(?::(\d{1,5}))?", text)
    port = int(found[2] or PORT) if found else -1
    if found is None or not 0 <= port <= 65535:
        raise InputError(
            f"--remote is {text}; must be HOST:PORT, HOST or :PORT (0 to 65535), "
            "such as 0.0.0.0:8765"
        )
    return Server(found[1].strip("[]") or HOST, port)


def require_server() -> None:
    """Check that the packages of a server are installed; InputError otherwise."""
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        raise InputError(f"the page needs {', '.join(missing)}: {install_command('web')}")


@dataclass(frozen=True)
class ServerAddress:
    """Address of a server with its token, also as a QR code for phones."""

    address: str
    fingerprint_sha256: str | None
    qr: str | None

    @property
    def text(self) -> str:
        """Text to display: address, fingerprint, QR code."""
        lines = [f"open {self.address}"]
        if self.fingerprint_sha256 is not None:
            lines.append(f"certificate SHA-256 {self.fingerprint_sha256}")
        if self.qr is not None:
            lines.append(self.qr.rstrip("\n"))
        return "\n".join(lines)


@contextmanager
def open_server(
    server: Server,
    session: HostSession | None = None,
    more: Collection[BaseRoute] = (),
    crowd: bool = False,
    public: Collection[str] | None = None,
) -> Iterator[ServerAddress]:
    """Serve the page, the `/control` route of a session, and more routes; yields the address.

    `crowd` allows hundreds of pages; `public` is an argument of `make_app`. The address is printed
    on standard error, with a QR code if a phone can reach it. InputError if the address or the
    certificate can't be used.
    """
    from overview_dsp.web import server as address
    from overview_dsp.web.certificate import fingerprint, secure_context, user_certificate
    from overview_dsp.web.security.auth_token import Access, load_token
    from overview_dsp.web.server import WebServer, listen, make_app

    host = server.host
    is_local = address.is_loopback(host)
    reached = address.public_host(host)
    if server.key is not None and server.cert is None:
        raise InputError("--key needs --cert; add it")
    secure, certificate = None, None
    if server.cert is not None:
        certificate = Path(server.cert)
    elif not is_local:
        own = sorted(address.machine_names())
        certificate = user_certificate([reached, "localhost", "127.0.0.1", "::1", *own])
    if certificate is not None:
        secure = secure_context(certificate, None if server.key is None else Path(server.key))
    names = address.machine_names() | ({host.lower()} if reached == host else set())
    token_file = server.token_file
    access = Access() if token_file is None else Access(token=load_token(token_file))
    app = make_app(access, names, note, session, more, public)
    socket = listen(host, server.port)
    scheme = "http" if secure is None else "https"
    url = address.page_url(scheme, reached, socket.getsockname()[1], access.token)
    running = WebServer(app, [socket], secure, note, crowd)
    try:
        opened = ServerAddress(
            url,
            None if certificate is None else fingerprint(certificate),
            None if is_local else address.qr_text(url),
        )
        click.echo(opened.text, err=True)
        yield opened
    finally:
        running.close()
