"""`overview presets import`: a haptic clip as a layer of a preset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from overview_dsp.cli.common import keep_input, show

if TYPE_CHECKING:
    from overview_dsp.offline.export.layers import Layer


@click.command(
    name="import",
    epilog="Example: overview presets import boing.ahap --kind goal --into football -o boing.toml",
)
@click.argument("clip")
@click.option("--kind", help="The kind of event that gets it.  [default: of a folder, file names]")
@click.option("--into", default="football", show_default=True, help="The preset it is laid into.")
@click.option(
    "--layer",
    type=click.Choice(["both", "tactor", "click"]),
    default="both",
    show_default=True,
    help="Its vibration as friction, its strikes as click, or both.",
)
@click.option("--check", is_flag=True, help="Only say what is wrong with the clip, by its format.")
@click.option("-o", "--out", help="The file.  [default: PRESET-KIND.toml here]")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def import_(
    clip: str,
    kind: str | None,
    into: str,
    layer: str,
    check: bool,
    out: str | None,
    as_json: bool,
) -> None:
    """Lay a haptic CLIP (AHAP or .haptic) into a preset: the hand plays it where the event is.

    Of an AHAP clip in two files, give either. Of a folder, each clip is laid into the kind that it
    is named after (goal.ahap), or, with --kind, its only one into that.
    """
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.design.presets.writing import save_preset
    from overview_dsp.files.toml import SUFFIX
    from overview_dsp.offline.export.layers import with_layer
    from overview_dsp.offline.export.reading import clips_in, read_clip

    if check:
        _check(clip, as_json)
        return
    laid = clips_in(clip, kind)
    for path in laid.values():
        keep_input(str(path))
    base = made = load_preset(into)
    for name, path in laid.items():
        made = with_layer(made, name, read_clip(path), cast("Layer", layer))
    named = next(iter(laid)) if len(laid) == 1 else Path(clip).name
    path = Path(out) if out is not None else Path(f"{base.name}-{named}{SUFFIX}")
    save_preset(made, path)
    report = {"file": str(path), "kinds": list(laid), "layer": layer}
    clips = ", ".join(f"{source} as its {name}" for name, source in laid.items())
    show(as_json, report, f"{path}: {into} with {clips}")


def _check(clip: str, as_json: bool) -> None:
    """Say what is wrong with a clip; InputError, with the first fault, if there is any."""
    from overview_dsp.errors import InputError
    from overview_dsp.offline.export.checking import check_clip

    faults = check_clip(clip)
    show(as_json, {"clip": clip, "faults": faults}, *([] if faults else [f"{clip}: valid"]))
    for fault in faults[1:]:
        click.echo(f"error: {clip}: {fault}", err=True)
    if faults:
        raise InputError(f"{clip}: {faults[0]}")
