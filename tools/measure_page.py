"""Measure the page: time to the first picture and sound, cost per frame, size.

    python tools/measure_page.py          needs playwright and a Chromium

The script simulates a phone of 390 x 844 points with three pixels per point and no graphics card.
The network has 1.6 Mb/s and a latency of 150 ms. For the frame cost the processor is slowed six
times. Each figure is the median of `ROUNDS`; on a busy machine the figures are larger.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.web.assets import folder_files
from overview_dsp.web.static_site import write_site
from tests.web.browser import launched, opened_driver
from tests.web.driving import PHONE, at, until
from tests.web.exported import opened_host
from tests.web.serving import served

ROUNDS = 5
SAVES = 15
NETWORK = {
    "offline": False,
    "latency": 150,
    "downloadThroughput": 1.6e6 / 8,
    "uploadThroughput": 0.75e6 / 8,
}
SLOWED = 6
DRAWN = """new MutationObserver(() => {
    if (!window.drawn && document.querySelectorAll("#canvas path").length > 10) {
        window.drawn = -1;
        requestAnimationFrame(() => { window.drawn = performance.now(); });
    }
}).observe(document, { childList: true, subtree: true });"""
FETCHED = """() => performance.getEntriesByType("resource")
    .filter(({ responseEnd }) => responseEnd <= window.drawn)
    .reduce((sum, { transferSize }) => sum + transferSize, 0)"""


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder, opened_driver() as driver:
        site = Path(folder) / "site"
        write_site(ov.load_timeline("world-cup-final-2018"), ov.load_preset("football"), site)
        with launched(driver) as browser, opened_host(site) as host:
            rounds = [measured(browser, host.url) for _ in range(ROUNDS)]
            saves = preset_delays(browser, Path(folder))
    print("| figure | value |\n|---|---|")
    for name, unit in (
        ("first picture", "ms"),
        ("bytes until then", "kB"),
        ("sound ready", "ms"),
        ("first sound after a touch", "ms"),
        ("main thread per frame, slowed 6 times", "ms"),
        ("of that, own scripts", "ms"),
        ("frames a second, not slowed", ""),
    ):
        print(f"| {name} | {statistics.median(one[name] for one in rounds):.1f} {unit} |")
    total = sum(map(len, folder_files(live=False).values()))
    print(f"| all of a folder's page, without its timeline | {total / 1e3:.0f} kB |")
    middle, most = statistics.median(saves), max(saves)
    print(f"| a preset saved on the desk, until the page's kernel has it | {middle:.0f} ms |")
    print(f"| the longest of {SAVES} | {most:.0f} ms |")


def measured(browser: Any, url: str) -> dict[str, float]:
    """One visit to the page."""
    context = browser.new_context(viewport=PHONE, device_scale_factor=3, service_workers="block")
    page = context.new_page()
    client = context.new_cdp_session(page)
    client.send("Network.enable")
    client.send("Network.emulateNetworkConditions", NETWORK)
    page.add_init_script(DRAWN)
    page.goto(url)
    until(page, "window.drawn > 0")
    found = {
        "first picture": page.evaluate("drawn"),
        "bytes until then": page.evaluate(FETCHED) / 1e3,
    }
    until(page, "p.sound.node")
    found["sound ready"] = page.evaluate("performance.now()")
    page.evaluate("addEventListener('pointerdown', () => { window.down = performance.now(); })")
    page.mouse.move(*at(page, 0.1))
    page.mouse.down()
    until(page, "p.meters?.clock > 0")
    found["first sound after a touch"] = page.evaluate("performance.now() - down")
    client.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.evaluate("""() => {
        window.frames = 0;
        const count = () => { frames += 1; requestAnimationFrame(count); };
        count();
    }""")
    began, first = page.evaluate("[performance.now(), frames]")
    drag(page)
    ended, last = page.evaluate("[performance.now(), frames]")
    found["frames a second, not slowed"] = (last - first) / (ended - began) * 1e3
    client.send("Emulation.setCPUThrottlingRate", {"rate": SLOWED})
    first, before = page.evaluate("frames"), spent(client)
    drag(page)
    count, after = page.evaluate("frames") - first, spent(client)
    for i, name in enumerate(("main thread per frame, slowed 6 times", "of that, own scripts")):
        found[name] = (after[i] - before[i]) / count * 1e3
    context.close()
    return found


def preset_delays(browser: Any, folder: Path) -> list[float]:
    """Return the times (ms) from saving a preset file until a served page's kernel receives it."""
    preset = folder / "mine.toml"
    text = 'schema = 2\nextends = "football"\n[tactor]\ngain_db = {}\n'
    preset.write_text(text.format(-1))
    timeline = ov.load_timeline("world-cup-final-2018")
    took = []
    with served(timeline, plays=False, preset=str(preset)) as server:
        page = browser.new_context(viewport=PHONE).new_page()
        page.goto(f"{server.origin}/#token={server.access.token}")
        until(page, "p.served?.presets.preset && p.sound.node")
        page.evaluate("""() => {
            const { node } = overview.sound;
            const change = node.change.bind(node);
            node.change = (bytes) => {
                change(bytes);
                window.changed = performance.timeOrigin + performance.now();
            };
        }""")
        for i in range(SAVES):
            page.evaluate("window.changed = 0")
            began = time.time()
            preset.write_text(text.format(-2 - i % 7))
            until(page, "changed")
            took.append(page.evaluate("changed") - 1e3 * began)
            time.sleep(0.05 * (i % 4))  # not in step with the server's checks
        page.context.close()
    return took


def drag(page: Any) -> None:
    """Drag a finger forward and back."""
    for position in (0.9, 0.2):
        page.mouse.move(*at(page, position), steps=60)


def spent(client: Any) -> tuple[float, float]:
    """Return the seconds of the main thread: total, and in scripts."""
    metrics = {
        one["name"]: one["value"] for one in client.send("Performance.getMetrics")["metrics"]
    }
    return metrics["TaskDuration"], metrics["ScriptDuration"]


if __name__ == "__main__":
    main()
