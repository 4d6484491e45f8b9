"""Bundle the page's scripts and style: `overview_dsp/web/bundle/`, from `web/*.js` and `web/site`.

    python tools/bundle_page.py [FOLDER]

Needs npm. Rollup joins the modules into few files, as a phone waits for each request: `main.js`,
the first picture; `page.js`, all that the page does; `served.js`, what only a server's page uses;
`live.js`, for a timeline that grows; `kernel.js`, which the page and `processor.js` (the audio
thread) share. esbuild shortens each. Both are under the MIT licence and installed into a temporary
folder, in the versions below: others may give other bytes.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WEB = Path(__file__).resolve().parents[1] / "overview_dsp" / "web"
BUNDLE = WEB / "bundle"
PACKAGES = {"esbuild": "0.28.2", "rollup": "4.68.8"}
MADE_OF = "made_of.json"
"""Beside the bundle: a digest of its sources, and the versions of what made it."""

ENTRIES = ["main.js", "processor.js"]
ALONE = ["worker.js", "style.css"]
"""Files that import no module."""

CONFIG = f"""
import {{ transform }} from "esbuild";

const minify = {{
  name: "minify",
  renderChunk: async (code) =>
    (await transform(code, {{ format: "esm", minify: true, target: "es2022" }})).code,
}};

export default {{
  input: {json.dumps(ENTRIES)},
  preserveEntrySignatures: false,
  output: {{ dir: "bundle", entryFileNames: "[name].js", chunkFileNames: "[name].js" }},
  plugins: [minify],
}};
"""


def sources() -> dict[str, bytes]:
    """Return what the bundle is made of, by name."""
    files = [*WEB.glob("*.js"), *(WEB / "site").glob("*.js"), WEB / "site" / "style.css"]
    return {file.name: file.read_bytes() for file in sorted(files, key=lambda file: file.name)}


def made_of() -> str:
    """Return what `MADE_OF` holds for the sources as they are."""
    digest = hashlib.sha256()
    for name, content in sources().items():
        digest.update(f"{name} {len(content)}\n".encode() + content)
    return json.dumps({"sources": digest.hexdigest(), **PACKAGES}, indent=2) + "\n"


def bundle(folder: Path) -> None:
    """Write the bundle into a folder, in place of what is there."""
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for file, content in sources().items():
            (work / file).write_bytes(content)
        (work / "package.json").write_text('{ "private": true }\n')
        (work / "config.mjs").write_text(CONFIG)
        packages = [f"{package}@{version}" for package, version in PACKAGES.items()]
        run(work, "npm", "install", "--silent", "--no-audit", "--no-fund", *packages)
        tools = work / "node_modules" / ".bin"
        run(work, tools / "rollup", "--silent", "--config", "config.mjs")
        run(work, tools / "esbuild", "--minify", "--log-level=error", "--outdir=bundle", *ALONE)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(work / "bundle", folder)
    (folder / MADE_OF).write_text(made_of())


def run(folder: Path, *command: str | Path) -> None:
    """Run a command in a folder; CalledProcessError if it fails."""
    subprocess.run([str(part) for part in command], check=True, cwd=folder)


if __name__ == "__main__":
    bundle(Path(sys.argv[1]) if len(sys.argv) > 1 else BUNDLE)
