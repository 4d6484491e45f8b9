"""`overview presets`: new, edit, morph, randomize.

`overview presets import`: a haptic clip as a layer of a preset.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from overview_dsp.cli.common import keep_input, show
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.offline.export.reading import Layer


SCHEMA_FILE = "preset.schema.json"
SCHEMA_LINE = f"#:schema ./{SCHEMA_FILE}"
"""What editors with Taplo complete and check a preset by."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,99}")


@click.command(epilog="Example: overview presets new my-match --from football")
@click.argument("name")
@click.option("--from", "base", default="football", show_default=True, help="What it starts from.")
@click.option("-o", "--out", help="The file.  [default: NAME.toml in your preset folder]")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def new(name: str, base: str, out: str | None, as_json: bool) -> None:
    """A new preset that extends another, with every parameter in it to be changed."""
    from overview_dsp.design.presets.library import LIBRARY, load_preset
    from overview_dsp.design.presets.reference import json_schema
    from overview_dsp.design.presets.writing import started_from
    from overview_dsp.files.atomic import make_folder, whole_file
    from overview_dsp.files.toml import SUFFIX

    if not _NAME.fullmatch(name):
        raise InputError(f"{name!r} is no name for a preset: letters, digits, - _ . and blanks")
    if out is None and name in LIBRARY.bundled:
        raise InputError(f"{name!r} is a bundled preset's name; choose another one")
    preset = load_preset(base)
    path = Path(out) if out is not None else make_folder(LIBRARY.own_folder) / (name + SUFFIX)
    if path.exists():
        raise InputError(f"{path}: is there already; edit it, or choose another name")
    named = Path(base).resolve() if base.endswith(SUFFIX) else base
    with whole_file(path) as temporary:
        text = f"{SCHEMA_LINE}\n{started_from(str(named), preset, name)}"
        temporary.write_text(text, encoding="utf-8", newline="\n")
    load_preset(path)
    # beside it, as the line says: what this version of the program knows
    with whole_file(path.with_name(SCHEMA_FILE)) as temporary:
        temporary.write_text(json.dumps(json_schema(), indent=1) + "\n", encoding="utf-8")
    line = f"{path}: extends {base}; change it with: overview presets edit {out or name}"
    show(as_json, {"file": str(path), "extends": base}, line)


@click.command(epilog="Example: overview presets edit my-match")
@click.argument("preset")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def edit(preset: str, as_json: bool) -> None:
    """Open one of your presets in your editor ($VISUAL, $EDITOR), and check it afterwards."""
    from overview_dsp.design.presets.library import bundled_presets, load_preset, preset_path

    if preset in bundled_presets():
        raise InputError(
            f"{preset!r} is bundled and stays as it is; make your own from it: overview presets "
            f"new my-{preset} --from {preset}"
        )
    path = preset_path(preset)
    try:
        click.edit(filename=str(path))
    except click.ClickException as error:
        raise InputError(f"{error.message}; set EDITOR to an editor that is there") from None
    load_preset(path)
    show(as_json, {"file": str(path), "valid": True}, f"{path}: valid")


@click.command(epilog="Example: overview presets morph football heart --steps 5 -o between")
@click.argument("first")
@click.argument("second")
@click.option("--steps", default=5, show_default=True, help="How many, both ends among them.")
@click.option("-o", "--out", default=".", show_default=True, help="Folder for the presets.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def morph(first: str, second: str, steps: int, out: str, as_json: bool) -> None:
    """Presets on the way from FIRST to SECOND."""
    from overview_dsp.design.presets.blending import morph as blend
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.design.presets.writing import save_preset
    from overview_dsp.files.atomic import make_folder
    from overview_dsp.files.toml import SUFFIX

    found = blend(load_preset(first), load_preset(second), steps)
    folder = make_folder(out)
    paths = [save_preset(preset, folder / (preset.name + SUFFIX)) for preset in found]
    show(as_json, {"files": [str(path) for path in paths]}, *paths)


@click.command(epilog="Example: overview presets randomize football --seed 7 -o seven.toml")
@click.argument("preset")
@click.option("--seed", default=0, show_default=True, help="The same seed, the same preset.")
@click.option("--amount", default=0.3, show_default=True, help="How far values go, 0 to 1.")
@click.option("-o", "--out", help="The file.  [default: PRESET-SEED.toml here]")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def randomize(preset: str, seed: int, amount: float, out: str | None, as_json: bool) -> None:
    """A preset near PRESET, by chance."""
    from overview_dsp.design.presets.blending import randomized
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.design.presets.writing import save_preset
    from overview_dsp.files.toml import SUFFIX

    if seed < 0:
        raise InputError(f"seed {seed} is out of range; it is 0 or more")
    found = randomized(load_preset(preset), seed, amount)
    path = save_preset(found, out if out is not None else found.name + SUFFIX)
    show(as_json, {"files": [str(path)]}, path)


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
    from overview_dsp.offline.export.reading import clips_in, read_clip, with_layer

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
    from overview_dsp.offline.export.reading import check_clip

    faults = check_clip(clip)
    show(as_json, {"clip": clip, "faults": faults}, *([] if faults else [f"{clip}: valid"]))
    for fault in faults[1:]:
        click.echo(f"error: {clip}: {fault}", err=True)
    if faults:
        raise InputError(f"{clip}: {faults[0]}")
