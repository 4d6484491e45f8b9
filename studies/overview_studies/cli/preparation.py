"""Commands that prepare a study: `check`, `lists` and `build`."""

from __future__ import annotations

import click

from overview_dsp.cli.extensions import announce_compile, progress_bar, show


@click.command(name="check", epilog="Example: overview study check study.toml")
@click.argument("study")
@click.option(
    "--measure-levels",
    "levels",
    is_flag=True,
    help="Measure the level of each stimulus, in dB of full scale.",
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def check(study: str, levels: bool, as_json: bool) -> None:
    """Report lists, trials, minutes and flaws of STUDY (a TOML file), before anyone takes part.

    Observers of three abilities complete it. Each warning names file, line, key and remedy.
    """
    from overview_studies.checking import summarize_design, summary_lines
    from overview_studies.design import load_design

    design = load_design(study)
    announce_compile()
    found = summarize_design(design, levels)
    show(as_json, found, *summary_lines(found))


@click.command(name="lists", epilog="Example: overview study lists study.toml -o lists")
@click.argument("study")
@click.option(
    "-o", "--output", "out", required=True, metavar="DIR", help="Folder to write the lists to."
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def lists(study: str, out: str, as_json: bool) -> None:
    """Write the trials of each participant in order, one CSV file per list."""
    from overview_dsp.cli.extensions import atomic_folder
    from overview_studies.checking import list_csv, list_name
    from overview_studies.design import load_design
    from overview_studies.folder import make_lists
    from overview_studies.stimuli import stimuli_of

    design = load_design(study)
    made = make_lists(design, stimuli_of(design))
    with atomic_folder(out, list_name(1)) as folder:
        for one in made:
            (folder / list_name(one["list"])).write_text(list_csv(one), encoding="utf-8")
    show(as_json, {"folder": out, "lists": len(made)}, f"{out}: {len(made)} lists")


@click.command(name="build", epilog="Example: overview study build study.toml -o folder")
@click.argument("study")
@click.option("-o", "--output", "out", required=True, metavar="DIR", help="Folder of the page.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def build(study: str, out: str, as_json: bool) -> None:
    """Write the page with stimuli and lists into a folder, for any web host or offline use.

    `overview study serve` serves it and stores the answers.
    """
    from overview_studies.design import load_design
    from overview_studies.folder import build_folder

    design = load_design(study)
    announce_compile()
    with progress_bar("rendering stimuli") as bar:
        size = build_folder(design, out, bar)
    report = {"folder": out, "bytes": size, "lists": design.file.participants}
    show(as_json, report, f"{out}: {design.file.participants} lists, {size / 1e6:.1f} MB")
