"""The certificate of https, the address and its QR code."""

from __future__ import annotations

import datetime
import hashlib
import ssl

import pytest
import segno
from cryptography import x509

import overview_dsp as ov
from overview_dsp.web import certificate, server


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(certificate.platformdirs, "user_config_path", lambda *a, **b: tmp_path)
    return tmp_path


def read(path):
    return x509.load_pem_x509_certificates(path.read_bytes())[0]


def test_a_certificate_is_made_once_kept_and_readable_by_its_owner_only(folder):
    path = certificate.user_certificate(["192.168.1.5", "localhost"])
    made = path.read_bytes()
    assert path.stat().st_mode & 0o077 == 0
    assert certificate.user_certificate(["192.168.1.5"]).read_bytes() == made
    assert [one.name for one in folder.iterdir()] == ["server.pem"]
    found = read(path)
    names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert [str(name.value) for name in names] == ["192.168.1.5", "localhost"]
    days = (found.not_valid_after_utc - found.not_valid_before_utc).days
    assert days <= 398
    assert not found.extensions.get_extension_for_class(x509.BasicConstraints).value.ca


def test_another_address_is_added_and_the_earlier_ones_stay(folder):
    certificate.user_certificate(["192.168.1.5"])
    path = certificate.user_certificate(["10.0.0.2"])
    both = path.read_bytes()
    assert certificate.user_certificate(["192.168.1.5", "10.0.0.2"]).read_bytes() == both


@pytest.mark.parametrize("kept", [b"", b"damaged", b"-----BEGIN CERTIFICATE-----\nx"])
def test_a_damaged_certificate_is_made_again(folder, kept):
    (folder / "server.pem").write_bytes(kept)
    certificate.secure_context(certificate.user_certificate(["localhost"]))


def test_a_certificate_that_expires_soon_is_made_again(folder):
    then = datetime.datetime.now(datetime.UTC) - datetime.timedelta(days=393)
    (folder / "server.pem").write_bytes(certificate.make_certificate(["localhost"], then))
    soon = read(folder / "server.pem").not_valid_after_utc
    assert read(certificate.user_certificate(["localhost"])).not_valid_after_utc > soon


def test_the_fingerprint_is_what_a_browser_shows(folder):
    path = certificate.user_certificate(["localhost"])
    der = ssl.PEM_cert_to_DER_cert(path.read_text()[path.read_text().index("-----BEGIN CERT") :])
    plain = hashlib.sha256(der).hexdigest().upper()
    assert certificate.fingerprint(path).replace(":", "") == plain


def test_a_certificate_that_cant_be_used_gives_a_one_line_error(folder, tmp_path):
    good = certificate.user_certificate(["localhost"])
    text = tmp_path / "text.pem"
    text.write_text("x")
    other = tmp_path / "other.pem"
    other.write_bytes(certificate.make_certificate(["localhost"]))
    for cert, key in ((text, None), (tmp_path / "none.pem", None), (good, other)):
        with pytest.raises(ov.InputError, match=cert.name):
            certificate.secure_context(cert, key)


def test_addresses_of_all_and_of_one_network():
    assert server.is_loopback("127.0.0.1")
    assert server.is_loopback("localhost")
    assert server.is_loopback("::1")
    assert not server.is_loopback("0.0.0.0")
    assert not server.is_loopback("laptop")
    assert server.public_host("0.0.0.0") != "0.0.0.0"
    assert server.public_host("192.168.1.5") == "192.168.1.5"
    assert server.page_url("https", "::1", 80, "t") == "https://[::1]:80/#token=t"


def test_the_qr_code_is_that_of_the_address():
    where = "https://192.168.1.5:8765/#token=abcdefghijklmnopqrstuv"
    text = server.qr_text(where)
    width = segno.make(where, error="l", micro=False).symbol_size()[0]
    lines = text.rstrip("\n").split("\n")
    assert max(map(len, lines)) == width
    assert width <= 45  # fits a terminal
    assert len(lines) == (width + 1) // 2
