"""`overview presets import`: a haptic clip as a layer of a preset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from overview_dsp.cli.common import keep_input, show

if TYPE_CHECKING:
    from overview_dsp.export.layers import Layer


@click.command(
    name="import",
    epilog="Example: overview presets import boing.ahap --kind goal --into football -o boing.toml",
)
@click.argument("clip")
@click.option("--kind", required=True, help="The kind of event that gets it.")
@click.option("--into", default="football", show_default=True, help="The preset it is laid into.")
@click.option(
    "--layer",
    type=click.Choice(["both", "tactor", "click"]),
    default="both",
    show_default=True,
    help="Its vibration as friction, its strikes as click, or both.",
)
@click.option("-o", "--out", help="The file.  [default: PRESET-KIND.toml here]")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def import_(clip: str, kind: str, into: str, layer: str, out: str | None, as_json: bool) -> None:
    """Lay a haptic CLIP (AHAP or .haptic) into a preset: the hand plays it where the event is."""
    from overview_dsp.export.layers import with_layer
    from overview_dsp.export.reading import read_clip
    from overview_dsp.files.toml import SUFFIX
    from overview_dsp.presets.library import load_preset
    from overview_dsp.presets.writing import save_preset

    keep_input(clip)
    base = load_preset(into)
    made = with_layer(base, kind, read_clip(clip), cast("Layer", layer))
    path = Path(out) if out is not None else Path(f"{base.name}-{kind}{SUFFIX}")
    save_preset(made, path)
    report = {"file": str(path), "kind": kind, "layer": layer}
    show(as_json, report, f"{path}: {into} with {clip} as its {kind}")
