"""Render the page's PNG icons from its SVG icon: `python tools/draw_icons.py` (needs Chromium)."""

from __future__ import annotations

import shutil
from pathlib import Path

from playwright.sync_api import sync_playwright

SITE = Path(__file__).parents[1] / "overview_dsp" / "web" / "site"
SIZES = (192, 512)


def main() -> None:
    drawing = (SITE / "icon.svg").read_text()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        for size in SIZES:
            page = browser.new_page(viewport={"width": size, "height": size})
            page.set_content(f"<style>body{{margin:0}}svg{{display:block}}</style>{drawing}")
            page.screenshot(path=str(SITE / f"icon-{size}.png"))
        browser.close()


if __name__ == "__main__":
    main()
