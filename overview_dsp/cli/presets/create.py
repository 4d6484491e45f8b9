"""The commands `overview presets` new, edit, morph, randomize and import."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

import overview_dsp as ov
from overview_dsp.cli.common import protect_inputs, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.presets.inspect import command
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import make_folder, write_file
from overview_dsp.files.toml import SUFFIX

if TYPE_CHECKING:
    from overview_dsp.offline.export.reading import Layer


SCHEMA_FILE = "preset.schema.json"
SCHEMA_LINE = f"#:schema ./{SCHEMA_FILE}"
"""First line of a preset, by which editors with Taplo complete and check it."""

BASE = option(default="football")

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,99}")


@cli_command("presets new my-match --base football", group=command)
def new(
    name: str, *, base: str = BASE, output: str | None = option(), as_json: bool = JSON
) -> None:
    """Write a preset that extends another one, with every parameter to edit."""
    from overview_dsp.design.presets.library import LIBRARY
    from overview_dsp.design.presets.reference import json_schema
    from overview_dsp.design.presets.writing import preset_template

    if not _NAME.fullmatch(name):
        raise InputError(f"preset name is {name!r}; must be letters, digits, - _ . and spaces")
    if output is None and name in LIBRARY.bundled:
        raise InputError(f"{name!r} is a bundled preset's name; choose another one")
    preset = ov.load_preset(base)
    path = (
        Path(output) if output is not None else make_folder(LIBRARY.user_folder) / (name + SUFFIX)
    )
    if path.exists():
        raise InputError(f"{path} already exists; edit it, or choose another name")
    named = Path(base).resolve() if base.endswith(SUFFIX) else base
    write_file(path, f"{SCHEMA_LINE}\n{preset_template(str(named), preset, name)}")
    ov.load_preset(path)
    write_file(path.with_name(SCHEMA_FILE), json.dumps(json_schema(), indent=1) + "\n")
    line = f"{path}: extends {base}; edit it with: overview presets edit {output or name}"
    show(as_json, {"file": str(path), "extends": base}, line)


@cli_command("presets edit my-match", group=command)
def edit(preset: str, *, as_json: bool = JSON) -> None:
    """Open your PRESET in an editor ($VISUAL, $EDITOR), and check it afterwards."""
    from overview_dsp.design.presets.library import preset_path

    if preset in ov.bundled_presets():
        raise InputError(
            f"{preset!r} is bundled and can't be edited; extend it: overview presets new "
            f"my-{preset} --base {preset}"
        )
    path = preset_path(preset)
    named = os.environ.get("VISUAL") or os.environ.get("EDITOR")
    if not (named or os.name == "nt" or (sys.stdin is not None and sys.stdin.isatty())):
        raise InputError(
            f"an editor needs a terminal; set EDITOR, or change {path} in any editor and check it: "
            f"overview presets check {preset}"
        )
    try:
        click.edit(filename=str(path))
    except click.ClickException as error:
        raise InputError(f"{error.message}; set EDITOR to an installed editor") from None
    ov.load_preset(path)
    show(as_json, {"file": str(path), "valid": True}, f"{path}: valid")


@cli_command("presets morph football heart --steps 5 -o between", group=command)
def morph(
    first: str,
    second: str,
    *,
    steps: int = option(default=5),
    output: str = option(default="."),
    as_json: bool = JSON,
) -> None:
    """Write presets interpolated between FIRST and SECOND."""
    from overview_dsp.design.presets.writing import save_preset

    found = ov.presets.morph(ov.load_preset(first), ov.load_preset(second), steps)
    folder = make_folder(output)
    paths = [save_preset(preset, folder / (preset.name + SUFFIX)) for preset in found]
    show(as_json, {"files": [str(path) for path in paths]}, *paths)


@cli_command("presets randomize football --seed 7 -o seven.toml", group=command)
def randomize(
    preset: str,
    *,
    seed: int = option(default=0),
    amount: float = option(default=0.3),
    output: str | None = option(),
    as_json: bool = JSON,
) -> None:
    """Write a random variation of PRESET."""
    from overview_dsp.design.presets.writing import save_preset

    if seed < 0:
        raise InputError(f"--seed is {seed}; must be 0 or more")
    found = ov.presets.randomize(ov.load_preset(preset), seed, amount)
    path = save_preset(found, output if output is not None else found.name + SUFFIX)
    show(as_json, {"files": [str(path)]}, path)


@cli_command(
    "presets import boing.ahap --as goal --base football -o boing.toml",
    name="import",
    group=command,
)
def import_(
    clip: str,
    *,
    kind: str | None = option("--as", metavar="KIND"),
    base: str = BASE,
    layer: str = option(type=click.Choice(["both", "tactor", "click"]), default="both"),
    check: bool = option(),
    output: str | None = option(),
    as_json: bool = JSON,
) -> None:
    """Add a haptic CLIP (AHAP, .haptic, HJIF, Android, .haps) to an event kind of a preset.

    An AHAP clip can have two files; name either. In a folder, each clip is added to the kind in its
    file name (goal.ahap). With --as, the folder must have one clip. The file keeps everything else
    in the base: its own base, variables and comments.
    """
    from overview_dsp.design.presets.text_update import changes_between, save_updated
    from overview_dsp.offline.export.reading import clips_in, read_clip, with_layer

    if check:
        faults = ov.export.check_clip(clip)
        show(as_json, {"clip": clip, "faults": faults}, *([] if faults else [f"{clip}: valid"]))
        for fault in faults[1:]:
            click.echo(f"error: {clip}: {fault}", err=True)
        if faults:
            raise InputError(f"{clip}: {faults[0]}")
        return
    clips = clips_in(clip, kind)
    protect_inputs(*map(str, clips.values()))
    preset = made = ov.load_preset(base)
    for name, path in clips.items():
        made = with_layer(made, name, read_clip(path), cast("Layer", layer))
    named = next(iter(clips)) if len(clips) == 1 else Path(clip).name
    path = Path(output) if output is not None else Path(f"{preset.name}-{named}{SUFFIX}")
    save_updated(base, changes_between(preset, made), path)
    report = {"file": str(path), "kinds": list(clips), "layer": layer}
    layers = ", ".join(f"{source} as {name}" for name, source in clips.items())
    show(as_json, report, f"{path}: {base} with {layers}")
