"""Browsers with a page that has the kernel's modules: a driven Chromium, an undriven Firefox."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import queue
import shutil
import subprocess
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.web.null_sink import null_sink
from tests.web.site import Site, opened_site

PROBED = ["--autoplay-policy=no-user-gesture-required", "--enable-precise-memory-info"]
UNTOUCHED = ("media.autoplay.default", "media.autoplay.blocking_policy")
"""Firefox's settings that let a page sound that nobody has touched, at 0."""

PATIENCE_S = 60.0


class Browser(ABC):
    """A page; `give` names bytes that it may fetch."""

    def __init__(self, site: Site) -> None:
        self.site = site

    def give(self, **named: bytes) -> None:
        self.site.given.update(named)

    @abstractmethod
    def call(self, function: str, *given: Any) -> Any:
        """The answer of one of `probe.js`'s functions."""

    def render(self, **given: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Samples, float32 (frames, 2), and what else `renderOffline` tells."""
        told = self.call("renderOffline", given)
        samples = np.frombuffer(base64.b64decode(told.pop("samples")), np.float32)
        return samples.reshape(-1, 2), told


class Chromium(Browser):
    """Driven by playwright."""

    def __init__(self, site: Site, page: Any) -> None:
        super().__init__(site)
        self._page = page

    def call(self, function: str, *given: Any) -> Any:
        return self._page.evaluate(
            "async ([name, given]) => (await import('/probe.js'))[name](...given)",
            [function, list(given)],
        )


class Firefox(Browser):
    """Started anew for each call: what drives it is no package of a registry."""

    def __init__(self, site: Site, program: str, profile: Path) -> None:
        super().__init__(site)
        self._program = program
        self._profile = profile
        settings = "".join(f"user_pref({json.dumps(name)}, 0);\n" for name in UNTOUCHED)
        (profile / "user.js").write_text(settings)

    def call(self, function: str, *given: Any) -> Any:
        self.give(job=json.dumps({"name": function, "given": given}).encode())
        answer = self.visit(self.site.url("unattended.html"), self.site.answers)
        assert "error" not in answer, answer
        return answer["value"]

    def visit(
        self,
        url: str,
        answers: queue.Queue[bytes],
        picture: Path | None = None,
        release: Callable[[], None] = lambda: None,
        environment: dict[str, str] | None = None,
    ) -> Any:
        """What a page posts, which is open meanwhile; a picture of it as it is then.

        Firefox pictures a page as soon as it is loaded: it must be held until `release`.
        """
        command = [self._program, "--headless", "--no-remote", "--profile", str(self._profile)]
        if picture is not None:
            command += ["--screenshot", str(picture), "--window-size", "390,844"]
        process = subprocess.Popen(
            [*command, url],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
        )
        try:
            told = json.loads(answers.get(timeout=PATIENCE_S))
            release()
            if picture is not None:
                process.wait(PATIENCE_S)
            return told
        except queue.Empty:
            pytest.fail(f"Firefox said nothing in {PATIENCE_S:g} s")
        finally:
            process.terminate()
            process.wait()


def firefox_program() -> str | None:
    """The Firefox of this machine."""
    return shutil.which("firefox-esr") or shutil.which("firefox")


@contextlib.contextmanager
def opened_driver() -> Iterator[Any]:
    """What drives browsers, one for all tests: two can't run side by side. Skips without it."""
    api: Any = pytest.importorskip(
        "playwright.sync_api", reason="needs a driver for a browser: pip install playwright"
    )
    with api.sync_playwright() as driver:
        yield driver


@contextlib.contextmanager
def launched(driver: Any, *options: str) -> Iterator[Any]:
    """A Chromium, or the Firefox of OVERVIEW_BROWSER=firefox; skips where there is none."""
    with contextlib.ExitStack() as stack:
        if os.environ.get("OVERVIEW_BROWSER") == "firefox":
            needed, kind = "Firefox: apt install firefox-esr", driver.firefox
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            given = {
                "executable_path": firefox_program(),
                "channel": "moz-firefox",
                "firefox_user_prefs": {"intl.accept_languages": "en-GB"},
                "env": stack.enter_context(null_sink(folder)),  # without one no page moves
            }
        else:
            needed = "Chromium: apt install chromium, or playwright install chromium"
            kind, arguments = driver.chromium, ["--no-sandbox", *options]
            given = {"executable_path": shutil.which("chromium"), "args": arguments}
        try:
            browser = kind.launch(**given)
        except Exception as error:
            pytest.skip(f"needs {needed} ({str(error).splitlines()[0]})")
        if kind is driver.chromium:  # as the tests expect dates
            make = browser.new_context
            browser.new_context = lambda **given: make(**{"locale": "en-GB", **given})
        yield browser
        browser.close()


@contextlib.contextmanager
def opened_chromium(driver: Any) -> Iterator[Chromium]:
    """A page that may sound at once."""
    with opened_site() as site, launched(driver, *PROBED) as browser:
        page = browser.new_page()
        page.goto(site.url("page.html"))
        yield Chromium(site, page)


@contextlib.contextmanager
def opened_firefox(profile: Path) -> Iterator[Firefox]:
    """Skips where there is none."""
    program = firefox_program()
    if program is None:
        pytest.skip("needs Firefox: apt install firefox-esr")
    with opened_site() as site:
        yield Firefox(site, program, profile)
