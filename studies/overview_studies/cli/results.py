"""Commands for answers, real or simulated: `simulate`, `analyse` and `export`."""

from __future__ import annotations

from typing import Any

import click

from overview_dsp.cli.extensions import announce_compile, note, progress_bar, show

TO = ("psych-ds", "bids", "csv", "r", "psignifit", "psychopy", "takes", "wav")


def _effects(context: Any, option: Any, values: tuple[str, ...]) -> dict[tuple[str, Any], float]:
    """Parse values of the form FACTOR.LEVEL=NUMBER."""
    found: dict[tuple[str, Any], float] = {}
    for text in values:
        named, equals, number = text.rpartition("=")
        factor, point, level = named.partition(".")
        try:
            found[factor, level] = float(number)
        except ValueError:
            equals = ""
        if not (equals and point and level):
            raise click.UsageError(f"--effect {text}: must be FACTOR.LEVEL=NUMBER, in units of d'")
    return found


@click.command(
    name="simulate",
    epilog="Example: overview study simulate folder -n 24 --d-prime 1.5 -o simulated.sqlite",
)
@click.argument("folder")
@click.option("-n", "count", type=click.IntRange(1, 10_000),
              help="Number of observers.  [default: participants of the study]")  # fmt: skip
@click.option("--d-prime", type=click.FloatRange(0.05, 10.0), default=1.5, show_default=True,
              help="Mean sensitivity of the observers.")  # fmt: skip
@click.option("--d-prime-sd", "d_prime_sd", type=click.FloatRange(0.0, 10.0), default=0.3,
              show_default=True, help="Standard deviation of d' between observers.")  # fmt: skip
@click.option("--lapse", type=click.FloatRange(0.0, 1.0), default=0.02, show_default=True,
              help="Share of trials answered at random.")  # fmt: skip
@click.option("--effect", "effects", multiple=True, callback=_effects, metavar="FACTOR.LEVEL=D",
              help="Effect of a level on d', such as mapping.static=-0.5.")  # fmt: skip
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True,
              help="Seed of the random numbers.")  # fmt: skip
@click.option("-o", "--output", "out", metavar="FILE", help="SQLite file to store the answers in.")
@click.option("--power-runs", "power", type=click.IntRange(2, 10_000), metavar="RUNS",
              help="Number of simulated studies; reports how many detect each effect.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def simulate(
    folder: str,
    count: int | None,
    d_prime: float,
    d_prime_sd: float,
    lapse: float,
    effects: dict[tuple[str, Any], float],
    seed: int,
    out: str | None,
    power: int | None,
    as_json: bool,
) -> None:
    """Simulate observers of known ability in the study in FOLDER (of `overview study build`).

    Their answers have a file of their own, which cannot be served, and all that is made from it is
    marked SIMULATED.
    """
    from overview_dsp.errors import InputError
    from overview_studies.analysis import analyse as analysed
    from overview_studies.folder import read_study
    from overview_studies.observers import Observers, simulate_answers, store_simulated
    from overview_studies.power import estimate_power, power_lines
    from overview_studies.report import summary
    from overview_studies.store import Store

    study, listed = read_study(folder)
    lists = {one["list"]: one for one in listed}
    factors = study["factors"].items()
    known = {(name, str(level)): (name, level) for name, one in factors for level in one["levels"]}
    for name in effects:
        if name not in known:
            levels = ", ".join(".".join(one) for one in known)
            raise InputError(f"--effect {'.'.join(name)}: unknown level; allowed: {levels}")
    typed = {known[name]: value for name, value in effects.items()}
    observers = Observers(d_prime, d_prime_sd, lapse, typed)
    participants = count or study["participants"]
    if power is not None:
        with progress_bar(f"simulating {power} studies") as bar:
            found = estimate_power(study, lists, observers, participants, power, seed, bar)
        show(as_json, found, *power_lines(found))
        return
    answers = simulate_answers(study, lists, observers, participants, seed)
    if out is not None:
        if participants > len(lists):
            raise InputError(
                f"-n {participants}: must be at most {len(lists)}, the number of lists"
            )
        store = Store(out, study, listed, simulated=True)
        try:
            store_simulated(store, answers)
        finally:
            store.close()
        note(f"{out}: {participants} simulated sessions")
    analysis = analysed(answers)
    show(as_json, analysis.as_json(), *summary(analysis))


@click.command(name="analyse", epilog="Example: overview study analyse responses.sqlite -o report")
@click.argument("answers", nargs=-1, required=True)
@click.option("--study", "folder", metavar="FOLDER",
              help="Built folder, required for CSV files of offline pages.")  # fmt: skip
@click.option(
    "-o", "--output", "out", metavar="DIR", help="Folder for the report: figures and tables."
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def analyse(answers: tuple[str, ...], folder: str | None, out: str | None, as_json: bool) -> None:
    """Estimate measures with intervals from ANSWERS (SQLite files, offline CSV files)."""
    from overview_studies.analysis import analyse as analysed
    from overview_studies.answers import read_answers
    from overview_studies.report import summary, write_report

    analysis = analysed(read_answers(answers, folder))
    if out is not None:
        note(f"{out}: {', '.join(write_report(analysis, out))}")
    for code, why in analysis.excluded.items():
        note(f"excluded: {code}: {why}")
    show(as_json, analysis.as_json(), *summary(analysis))


@click.command(name="export", epilog="Example: overview study export responses.sqlite -o dataset")
@click.argument("answers", nargs=-1)
@click.option("--to", type=click.Choice(TO), default=TO[0], show_default=True,
              help="Output format.")  # fmt: skip
@click.option("-o", "--output", "out", required=True, metavar="DIR", help="Folder to write to.")
@click.option("--study", metavar="STUDY", help="Study file for psychopy, takes and wav; built "
              "folder for CSV files of offline pages.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def export(answers: tuple[str, ...], to: str, out: str, study: str | None, as_json: bool) -> None:
    """Write ANSWERS (SQLite files, offline CSV files) for other tools.

    psych-ds and bids are datasets to publish. csv, r and psignifit are tables to analyse. psychopy
    writes the lists with sounds. takes and wav write the movement and the output of each trial.
    """
    from overview_dsp.errors import InputError
    from overview_studies.answers import read_answers
    from overview_studies.design import load_design

    file = study if study is not None and study.endswith(".toml") else None
    if to in ("psychopy", "takes", "wav") and file is None:
        raise InputError(f"--to {to} requires the study file; add --study study.toml")
    if to == "psychopy":
        from overview_studies.psychopy import export_psychopy

        if answers:
            raise InputError("--to psychopy writes lists, not answers; remove the answers")
        announce_compile()
        with progress_bar("rendering sounds") as bar:
            count = export_psychopy(load_design(str(file)), out, bar)
        show(as_json, {"folder": out, "sounds": count}, f"{out}: {count} sounds")
        return
    if not answers:
        raise InputError(f"--to {to} requires answers; add responses.sqlite or offline CSV files")
    found = read_answers(answers, None if file else study)
    if to in ("takes", "wav"):
        from overview_studies.replay import export_takes

        with progress_bar("writing takes") as bar:
            count = export_takes(found, load_design(str(file)), out, to == "wav", bar)
        show(as_json, {"folder": out, "takes": count}, f"{out}: {count} takes")
        return
    from overview_studies.exporting import export_answers

    names = export_answers(found, to, out)
    show(as_json, {"folder": out, "files": names}, f"{out}: {len(names)} files")
