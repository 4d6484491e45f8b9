"""The browser of the package's own pages."""

from tests.web.conftest import axe, chromium, driver

__all__ = ["axe", "chromium", "driver"]
