from __future__ import annotations

import json

import pytest

import overview_dsp as ov
from overview_dsp.design.presets.library import preset_path
from overview_dsp.design.presets.parameters import PARAMETERS
from tests.cli.running import overview, refused


def test_list_names_every_bundled_preset_with_its_purpose():
    lines = overview("presets", "list").out.splitlines()
    assert [line.split()[0] for line in lines] == list(ov.bundled_presets())
    for name, line in zip(ov.bundled_presets(), lines, strict=True):
        assert ov.load_preset(name).description in line


def test_list_as_json_has_the_same_presets():
    report = json.loads(overview("presets", "list", "--json").out)
    assert [entry["name"] for entry in report] == list(ov.bundled_presets())
    assert all(entry["title"] and entry["description"] for entry in report)


@pytest.mark.parametrize("name", ov.bundled_presets())
def test_show_reports_every_parameter_and_kind(name):
    page = overview("presets", "show", name).out
    for known in PARAMETERS.values():
        assert known.doc in page
    for kind in ov.load_preset(name).kinds:
        assert f"  {kind} " in page
    report = json.loads(overview("presets", "show", name, "--json").out)
    assert {id: entry["value"] for id, entry in report["parameters"].items()} == dict(
        ov.load_preset(name).values
    )


def test_check_reports_valid_presets():
    outcome = overview("presets", "check", *ov.bundled_presets())
    assert outcome.code == 0
    assert outcome.out.count(": valid, ") == len(ov.bundled_presets())


def broken(folder, name="mine.toml"):
    text = preset_path("football").read_text(encoding="utf-8")
    path = folder / name
    path.write_text(text.replace("k1 = 0.00036", "k1 = 1.5e3"), encoding="utf-8")
    return 1 + text.splitlines().index("k1 = 0.00036")


def test_check_names_file_line_key_and_range_of_a_fault(folder):
    line = broken(folder)
    refused(
        overview("presets", "check", "mine.toml"),
        f"mine.toml:{line}: disk.k1",
        "1e-05 to 1 N·m/rad",
    )
    refused(overview("presets", "show", "mine.toml"), f"mine.toml:{line}: disk.k1")
    refused(overview("presets", "check", "nobody"), "'nobody'")


def test_check_continues_after_a_fault(folder):
    broken(folder)
    outcome = overview("presets", "check", "mine.toml", "football", "nobody")
    assert outcome.code == 2
    assert "football: valid" in outcome.out
    assert [line.split()[0] for line in outcome.errors] == ["error:"] * 2
    assert "mine.toml" in outcome.errors[0]
    assert "nobody" in outcome.errors[1]


def test_check_as_json_has_the_valid_and_the_faulty(folder):
    broken(folder)
    outcome = overview("presets", "check", "football", "mine.toml", "--json")
    assert outcome.code == 2
    good, bad = json.loads(outcome.out)
    assert good["valid"] is True
    assert "goal" in good["kinds"]
    assert bad["valid"] is False
    assert "disk.k1" in bad["error"]
