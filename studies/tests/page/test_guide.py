"""The guide on studies, line by line: what a researcher types, and one participant in a browser."""

from __future__ import annotations

import csv
import json
import shlex
from pathlib import Path

from studies.tests.page.participant import Reader, take_part
from studies.tests.page.study_server import served_study
from studies.tests.page.test_page import feel_and_choose
from tests.cli.running import overview
from tests.docs.markdown_blocks import ROOT, blocks_of

PAGE = Path("docs/guide/studies.md")
QUESTION = "What did you feel?"


def test_the_lines_of_the_guide_lead_to_a_study_of_one_person_alone(
    chromium, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    lines = []
    for block in blocks_of(PAGE, (ROOT / PAGE).read_text()):
        if block.file:
            # one repeat instead of eight, for a session of a minute
            Path(block.file).write_text(block.text.replace("repeats = 8", "repeats = 1"))
        elif block.language == "sh":
            lines += [shlex.split(line, comments=True) for line in block.text.splitlines()]
    lines = [line[2:] for line in lines if line[:2] == ["overview", "study"]]
    served = [line for line in lines if line[0] == "serve"]
    assert served == [["serve", "folder", "--db", "answers.sqlite", "--host", "0.0.0.0"]]
    before, after = lines[: lines.index(served[0])], lines[lines.index(served[0]) + 1 :]
    assert [line[0] for line in before].count("simulate") == 1
    assert {"analyse", "export"} <= {line[0] for line in after}

    def run(line):
        outcome = overview("study", *line)
        assert outcome.code == 0, (line, outcome.err)
        return outcome.out

    for line in before:
        run(line)
    with served_study(Path("folder"), Path("answers.sqlite")) as server:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(server.url)
        reader = Reader(page)
        take_part(reader, feel_and_choose([1, 2, 3, 4] * 20), QUESTION)
        context.close()
    told = {line[0]: run(line) for line in after}
    assert "SIMULATED" not in told["analyse"]
    results = json.loads(Path("report/results.json").read_text())
    assert (results["participants"], results["simulated"]) == (1, False)
    with open("report/responses.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["participant"] for row in rows} == {"p001"}
    assert {row["source"] for row in rows} <= {"keys", "touch"}
    for path in (*Path("report").rglob("*"), *Path("dataset").rglob("*")):
        assert "SIMULATED" not in path.name
        if path.suffix in (".csv", ".json", ".txt", ".md", ".svg", ".R"):
            assert "SIMULATED" not in path.read_text(), path
    assert list(Path("rehearsal").glob("SIMULATED-*.png"))
