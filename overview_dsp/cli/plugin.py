"""`overview plugin`: a timeline as an instrument of a digital audio workstation."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import click

from overview_dsp.cli.common import note, print_json, window_options
from overview_dsp.cli.options.timeline import open_part, preset_for, timeline_options
from overview_dsp.errors import InputError, OverviewWarning

_FORMATS = ("clap", "vst3", "lv2")
_TARGETS = ("x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-macos", "aarch64-macos")
_ALL_BUNDLED = "overView DSP"


@click.group(name="plugin", epilog="Example: overview plugin build match.json --to clap -o plugins")
def command() -> None:
    """Build audio plugins that play a timeline without Python."""


@command.command(
    name="build", epilog="Example: overview plugin build match.json --to clap -o ~/.clap"
)
@click.argument("timelines", nargs=-1, metavar="[TIMELINE]...")
@click.option(
    "--preset",
    "presets",
    multiple=True,
    help="A name or a .toml file; of several, one is chosen in the host.  "
    "[default: those that fit the data; without TIMELINE, every bundled one]",
)
@click.option("--to", "to", required=True, type=click.Choice(_FORMATS), help="Its format.")
@click.option(
    "--target",
    type=click.Choice(_TARGETS),
    help="The machine it is for; needs ziglang (pip install ziglang).  [default: this one]",
)
@click.option("-o", "--out", default=".", show_default=True, help="The folder it is put into.")
@click.option("--name", help="What it is called.  [default: the first TIMELINE's name]")
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@window_options
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def build(
    timelines: tuple[str, ...],
    presets: tuple[str, ...],
    to: str,
    target: str | None,
    out: str,
    name: str | None,
    seed: int,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    load: dict[str, Any],
    as_json: bool,
) -> None:
    """Compile timelines to a plugin, with the samples of `render`; it needs a C compiler.

    Of several TIMELINEs, one is chosen in the host, as are presets. Without any it is a plugin of
    everything that is bundled: the timelines, each in every preset.
    """
    from overview_dsp.data.readers import BUNDLED
    from overview_dsp.design.presets.library import bundled_presets, load_preset
    from overview_dsp.offline.export.plugins import build_plugin

    data = {
        Path(timeline).stem: open_part(timeline, load, window, zoom_to)
        for timeline in timelines or tuple(BUNDLED)
    }
    if len(data) < len(timelines):
        raise InputError("two timelines of a plugin have the same name: name each once")
    everything = not presets and not timelines
    if everything:
        presets = bundled_presets()
    fitting = dict.fromkeys(preset_for(timeline, None) for timeline in data.values())
    chosen = [load_preset(preset) for preset in presets or fitting]
    called = name or (Path(timelines[0]).stem if timelines else _ALL_BUNDLED)
    if target:
        note(f"compiling for {target}; ziglang's first time for a machine takes a minute or more")
    with warnings.catch_warnings():
        if everything:
            # that not every bundled preset names what a bundled timeline holds was nobody's choice
            warnings.simplefilter("ignore", OverviewWarning)
        made = build_plugin(data, chosen, to, out, name=called, seed=seed, target=target)
    names = [preset.name for preset in chosen]
    if as_json:
        report = {"format": to, "file": str(made), "timelines": list(data), "presets": names}
        print_json({**report, "target": target} if target else report)
        return
    timed = f"{', '.join(data)} in " if len(data) > 1 else ""
    click.echo(f"{made}: {timed}{', '.join(names)}; clicks on output 1, the tactor on output 2")
