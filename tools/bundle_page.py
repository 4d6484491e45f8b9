"""Bundle the page's scripts and style: `web/*.js` and `web/site` into `overview_dsp/web/bundle/`.

    python tools/bundle_page.py [FOLDER]

The script needs npm. Rollup joins the modules into few files, since each request delays a phone:
`main.js` (first picture), `page.js` (the page), `served.js` (features of a server), `live.js` (live
timelines), `embedded.js` (in an article) and `kernel.js`, which the page and `processor.js` (audio
thread) share. esbuild minifies each file. Both tools have the MIT licence. They are installed into
a temporary folder, in the versions below: other versions may produce other bytes.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WEB = Path(__file__).resolve().parents[1] / "overview_dsp" / "web"
BUNDLE = WEB / "bundle"
PACKAGES = {"esbuild": "0.28.2", "rollup": "4.68.8"}
BUILD_INFO = "build_info.json"
"""File in the bundle with a digest of the sources and the versions of the tools."""

ENTRIES = ["main.js", "processor.js"]
STANDALONE = ["worker.js", "embed.js", "style.css", "served.css", "gallery.css"]
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
    """Return the source files of the bundle by name."""
    site = WEB / "site"
    files = [*WEB.glob("*.js"), *site.glob("*.js"), *site.glob("*.css")]
    return {file.name: file.read_bytes() for file in sorted(files, key=lambda file: file.name)}


def build_info() -> str:
    """Return the content of `BUILD_INFO` for the current sources."""
    digest = hashlib.sha256()
    for name, content in sources().items():
        digest.update(f"{name} {len(content)}\n".encode() + content)
    return json.dumps({"sources": digest.hexdigest(), **PACKAGES}, indent=2) + "\n"


def bundle(folder: Path) -> None:
    """Write the bundle into a folder and replace its content."""
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        files = sources()
        files["kernel.js"] = inlined(files["kernel.js"].decode(), files["layout.js"].decode())
        for file, content in files.items():
            (work / file).write_bytes(content)
        (work / "package.json").write_text('{ "private": true }\n')
        (work / "config.mjs").write_text(CONFIG)
        packages = [f"{package}@{version}" for package, version in PACKAGES.items()]
        run(work, "npm", "install", "--silent", "--no-audit", "--no-fund", *packages)
        tools = work / "node_modules" / ".bin"
        run(work, tools / "rollup", "--silent", "--config", "config.mjs")
        run(
            work, tools / "esbuild", "--minify", "--log-level=error", "--outdir=bundle", *STANDALONE
        )
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(work / "bundle", folder)
    (folder / BUILD_INFO).write_text(build_info())


def inlined(script: str, layout: str) -> bytes:
    """Return a script with the numbers of `layout.js` instead of `L.NAME`.

    The page uses few of the names; a frozen object would keep them all.
    """
    numbers = dict(re.findall(r"^  (\w+): (-?\d+),$", layout, re.MULTILINE))
    return re.sub(r"\bL\.(\w+)", lambda found: numbers[found[1]], script).encode()


def run(folder: Path, *command: str | Path) -> None:
    """Run a command in a folder; raise CalledProcessError if it fails."""
    subprocess.run([str(part) for part in command], check=True, cwd=folder)


if __name__ == "__main__":
    bundle(Path(sys.argv[1]) if len(sys.argv) > 1 else BUNDLE)
