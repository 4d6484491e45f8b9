"""The https certificate, created on first use and renewed before it expires.

Phones report motion to secure pages only. The certificate is self-signed, so a browser warns once.
The command line prints its fingerprint for comparison.
"""

from __future__ import annotations

import datetime
import ssl
from collections.abc import Iterable
from pathlib import Path

import platformdirs
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import make_folder, write_file
from overview_dsp.web.security.auth_token import parse_ip

DAYS = 397
"""Some phones reject certificates with a longer validity."""

RENEW_DAYS = 7
MAX_NAMES = 20
FILE = "server.pem"


def user_certificate(names: Iterable[str]) -> Path:
    """Return the file of a certificate for these names and addresses; create it if needed.

    InputError or OutputError if it can't be written.
    """
    path = platformdirs.user_config_path("overview-dsp", appauthor=False) / FILE
    required = list(dict.fromkeys(names))
    stored = _names(path)
    if stored is None or not set(required) <= set(stored):
        # earlier names stay: a laptop alternates between networks
        all_names = list(dict.fromkeys([*required, *(stored or ())]))[:MAX_NAMES]
        make_folder(path.parent)
        write_file(path, make_certificate(all_names), private=True)
    return path


def make_certificate(names: list[str], now: datetime.datetime | None = None) -> bytes:
    """Create a key and its certificate for names and addresses; return both as PEM."""
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
        .add_extension(x509.SubjectAlternativeName([_general_name(one) for one in names]), False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), False)
        .sign(key, hashes.SHA256())
    )
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    ) + certificate.public_bytes(serialization.Encoding.PEM)


def secure_context(certificate: Path, key: Path | None = None) -> ssl.SSLContext:
    """Return a context for TLS 1.2 or later with a PEM certificate and its key.

    InputError if the files can't be read, or certificate and key don't match.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key, password=_no_password)
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or getattr(error, "strerror", None) or error
        files = f"{certificate} and {key}" if key is not None else certificate
        raise InputError(
            f"{files}: not a certificate with its key ({reason}); must be PEM without a password"
        ) from None
    return context


def fingerprint(certificate: Path) -> str:
    """Return the SHA-256 of the first certificate of a PEM file, as browsers show it."""
    first = x509.load_pem_x509_certificates(certificate.read_bytes())[0]
    return first.fingerprint(hashes.SHA256()).hex(":").upper()


def _no_password() -> str:
    raise ValueError("the key has a password")


def _names(path: Path) -> list[str] | None:
    """Return the names of a stored certificate; None if it is missing, damaged or expires soon."""
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


def _general_name(name: str) -> x509.GeneralName:
    address = parse_ip(name)
    return x509.DNSName(name) if address is None else x509.IPAddress(address)
