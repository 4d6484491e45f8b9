"""The certificate of https: made on first use, kept, made again before it is over.

Phones give motion to secure pages only. It is signed by itself, so a browser warns once; its
fingerprint is printed to compare.
"""

from __future__ import annotations

import contextlib
import datetime
import ipaddress
import ssl
from collections.abc import Iterable
from pathlib import Path

import platformdirs
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, make_folder

DAYS = 397
"""Longer ones are refused by some phones."""

RENEW_DAYS = 7
MAX_NAMES = 20
FILE = "server.pem"


def certificate_file() -> Path:
    """Where key and certificate are kept: `server.pem` in the user's config folder."""
    return platformdirs.user_config_path("overview-dsp", appauthor=False) / FILE


def own_certificate(names: Iterable[str]) -> Path:
    """The file of a certificate for these names and addresses, made if it isn't there yet.

    Raises
    ------
    InputError, OutputError
        It can't be written.
    """
    path = certificate_file()
    wanted = list(dict.fromkeys(names))
    known = _names(path)
    if known is None or not set(wanted) <= set(known):
        # earlier names stay: a laptop goes to and fro between networks
        both = list(dict.fromkeys([*wanted, *(known or ())]))[:MAX_NAMES]
        make_folder(path.parent)
        with atomic_file(path, private=True) as temporary:
            temporary.write_bytes(make_certificate(both))
    return path


def make_certificate(names: list[str], now: datetime.datetime | None = None) -> bytes:
    """A new key and its certificate for names and addresses, as PEM."""
    now = now or datetime.datetime.now(datetime.UTC)
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "overView DSP, this machine only")])
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))  # a phone's clock may be behind
        .not_valid_after(now + datetime.timedelta(days=DAYS - 1))
        .add_extension(x509.SubjectAlternativeName([_general(one) for one in names]), False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), False)
        .sign(key, hashes.SHA256())
    )
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    ) + certificate.public_bytes(serialization.Encoding.PEM)


def secure_context(certificate: Path, key: Path | None = None) -> ssl.SSLContext:
    """TLS 1.2 or later with a certificate (PEM; its key in the same file, or another one).

    Raises
    ------
    InputError
        They can't be read, or don't belong together.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key, password=_no_password)
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or getattr(error, "strerror", None) or error
        where = f"{certificate} and {key}" if key is not None else certificate
        raise InputError(
            f"{where}: no certificate with its key, as PEM without a password ({reason})"
        ) from None
    return context


def fingerprint(certificate: Path) -> str:
    """SHA-256 of the (first) certificate of a PEM file, as browsers show it."""
    found = x509.load_pem_x509_certificates(certificate.read_bytes())[0]
    return found.fingerprint(hashes.SHA256()).hex(":").upper()


def _no_password() -> str:
    raise ValueError("it has a password")


def _names(path: Path) -> list[str] | None:
    """What a kept certificate is for; None if there is none, a damaged or an old one."""
    try:
        content = path.read_bytes()
        serialization.load_pem_private_key(content, None)
        certificate = x509.load_pem_x509_certificates(content)[0]
        extension = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName)
    except (OSError, ValueError, TypeError, x509.ExtensionNotFound):
        return None
    soon = datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=RENEW_DAYS)
    if certificate.not_valid_after_utc < soon:
        return None
    return [str(one.value) for one in extension.value]


def _general(name: str) -> x509.GeneralName:
    with contextlib.suppress(ValueError):
        return x509.IPAddress(ipaddress.ip_address(name))
    return x509.DNSName(name)
