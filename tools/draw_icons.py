"""Render the page's PNG icons from its SVG icon: `python tools/draw_icons.py`.

The script needs Chromium and Pillow.
"""

from __future__ import annotations

import io
import re
import shutil
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

SITE = Path(__file__).parents[1] / "overview_dsp" / "web" / "site"
SIZES = (192, 512)


def main() -> None:
    drawing = (SITE / "icon.svg").read_text()
    # no shades at the edges: a phone shows the icon much smaller
    colours = dict.fromkeys(re.findall(r"#(\w{6})", drawing))
    palette = Image.new("P", (1, 1))
    palette.putpalette(b"".join(map(bytes.fromhex, colours)))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        for size in SIZES:
            page = browser.new_page(viewport={"width": size, "height": size})
            page.set_content(f"<style>body{{margin:0}}svg{{display:block}}</style>{drawing}")
            picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            few = picture.quantize(palette=palette, dither=Image.Dither.NONE)
            few.save(SITE / f"icon-{size}.png", optimize=True)
        browser.close()


if __name__ == "__main__":
    main()
