from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overview_dsp.data.readers import FORMATS, Format, data_file, formats, load_timeline
from overview_dsp.data.readers import registry as loading
from overview_dsp.errors import InputError
from tests.data.readers.statsbomb_match import full_match

NATIVE = '{"overview_timeline": 1, "duration_s": 9, "events": [{"time_s": 1, "kind": "a"}]}'
EVENT_LIST = "time_s,kind\n1,a\n"


def refused(path: Any, words: str, **options: Any) -> str:
    with pytest.raises(InputError, match=words) as caught:
        load_timeline(path, **options)
    text = str(caught.value)
    assert text.count("\n") <= 1  # the second line: what it comes nearest to
    assert text.encode()
    return text


@pytest.mark.parametrize("name", ["x.json", "x.csv", "x", "x.wav"])
def test_a_file_is_detected_by_its_content_not_by_its_name(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    contents = {
        NATIVE: {"a": 1},
        EVENT_LIST: {"a": 1},
        json.dumps(full_match()): {"goal": 1, "own_goal": 1},
    }
    for content, kinds in contents.items():
        path.write_text(content)
        assert kinds.items() <= load_timeline(path).kinds().items()
        assert load_timeline(str(path)) == load_timeline(path)


def test_a_missing_file_gives_a_one_line_error_that_knows_the_bundled_names(tmp_path: Path) -> None:
    refused(tmp_path / "no.json", r"no\.json: no such file.*world-cup-final-2018")
    refused("", "no such file")


def test_a_folder_gives_a_one_line_error(tmp_path: Path) -> None:
    assert refused(tmp_path, "folder") == f"{tmp_path}: is a folder; name a file in it"


def test_a_file_as_a_folder_gives_a_one_line_error(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("a")
    refused(tmp_path / "x" / "y", "can't be read")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    pipe = tmp_path / "pipe"
    assert refused(pipe, "regular").startswith(f"{pipe}: isn't a regular file; ")


@pytest.mark.parametrize("path", ["a\0b", "x" * 5000, None, 3, 3.5, load_timeline])
def test_an_invalid_path_gives_a_one_line_error(path: Any) -> None:
    refused(path, "can't be read|is not a path")


def test_an_empty_file_gives_a_one_line_error(tmp_path: Path) -> None:
    (tmp_path / "e.json").write_bytes(b"")
    refused(tmp_path / "e.json", r"e\.json: is empty")
    for blanks in (b"\n \n", b"\xef\xbb\xbf"):
        (tmp_path / "e.json").write_bytes(blanks)
        refused(tmp_path / "e.json", "blanks only")


@pytest.mark.parametrize("start", [b"", b"{", b"[", b"time_s,kind\n", b"\xff\xfe", b"\xef\xbb\xbf"])
def test_a_megabyte_of_noise_gives_a_one_line_error(start: bytes, tmp_path: Path) -> None:
    noise = np.random.default_rng(1).bytes(1_000_000)
    (tmp_path / "noise").write_bytes(start + noise)
    text = refused(tmp_path / "noise", r"noise: binary data, not a format that can be read")
    assert "\nnearest: " in text


def test_noise_after_a_long_good_start_gives_a_one_line_error(tmp_path: Path) -> None:
    (tmp_path / "n").write_bytes(b"time_s,kind\n" + b"1,a\n" * 20_000 + b"\xff\x00")
    refused(tmp_path / "n", r"n: byte 80012 isn't utf-8 text")
    (tmp_path / "n").write_bytes(b"[" + b" " * 70_000 + b"\xff")
    refused(tmp_path / "n", r"n: byte 70001 isn't utf-8 text")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('{"a": 1, "b": 2}', "a JSON object with the keys 'a', 'b'"),
        ("{}", r"a JSON object with the keys \(none\)"),
        ("[]", "a JSON list of 0 entries"),
        ("[1, 2]", "a JSON list of 2 entries"),
        ('{"\\ud800": 1}', r"a JSON object with the keys '\\ud800'"),
        ("3", "text that begins '3'"),
        ("name,colour\nx,red\n", "text that begins 'name,colour'"),
        ("hello\nworld", "text that begins 'hello'"),
    ],
)
def test_an_unknown_content_is_described_with_what_it_comes_nearest_to(
    content: str, words: str, tmp_path: Path
) -> None:
    (tmp_path / "x").write_text(content)
    refused(tmp_path / "x", rf"x: {words}, not a .*\nnearest: .*; overview timeline formats lists")


def test_a_character_across_the_end_of_the_head_is_no_obstacle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = "time_s,kind,label\n1,a,ü\n".encode()
    monkeypatch.setattr(data_file, "HEAD_BYTES", content.index(b"\xc3") + 1)
    (tmp_path / "x").write_bytes(content)
    assert load_timeline(tmp_path / "x").events[0].label == "ü"


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("time_s,kind,label\n1,a,Müller\n", ["Müller"]),
        ("Zeit;Ereignis;Text\n08:30;Frühstück;mit Käse\n12:00;Spaß;\n", ["mit Käse", "Spaß"]),
        ("0:00 Einführung\n1:15 Spaß\n9:40 Ende\n", ["Einführung", "Spaß", "Ende"]),
        ("minute,type,player,team\n18,goal,Müller,X\n28,goal,Özil,Y\n", ["Müller", "Özil"]),
        ("1\n00:00:01,000 --> 00:00:02,000\nGrüße\n", ["Grüße"]),
    ],
)
def test_lists_that_are_not_utf8_are_read_as_windows_writes_them(
    text: str, labels: list[str], tmp_path: Path
) -> None:
    (tmp_path / "x").write_bytes(text.encode("cp1252"))
    (tmp_path / "utf8").write_text(text, encoding="utf-8")
    timeline = load_timeline(tmp_path / "x")
    shown = "\n".join(event.label for event in timeline.events)
    assert all(label in shown for label in labels)
    assert timeline.events == load_timeline(tmp_path / "utf8").events
    assert "the file isn't UTF-8; read as Windows-1252" in timeline.notes


def test_json_that_is_not_utf8_gives_a_one_line_error(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes('[{"time": 1, "event": "Müller"}]'.encode("cp1252"))
    refused(tmp_path / "x", "text that isn't UTF-8 .save it as UTF-8.")


@pytest.mark.parametrize("inside", ["xl/workbook.xml", "content.xml"])
def test_a_spreadsheet_is_named_as_one(inside: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "x", "w") as document:
        document.writestr("mimetype", "a spreadsheet's")
        document.writestr(inside, "<x/>")
    # with and without the package that reads spreadsheets
    refused(tmp_path / "x", r"x: not a readable spreadsheet|reading a spreadsheet \(a CSV file")


def test_a_matlab_file_without_sound_is_named_as_one(tmp_path: Path) -> None:
    (tmp_path / "x.mat").write_bytes(
        b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124) + bytes(99)
    )
    refused(tmp_path / "x.mat", "a MATLAB file without sound; write its columns as CSV")


def test_text_with_a_broken_quote_is_described_with_its_file(tmp_path: Path) -> None:
    (tmp_path / "x.md").write_text('# A\n\n| a | b |\n|---|---|\n| x | y |\n"quoted" | c |\n')
    refused(tmp_path / "x.md", "x.md: text that begins '# A'")


@pytest.mark.parametrize("content", ["[", "{", '{"a": ', '[{"period": 1', '{"overview_timeline"'])
def test_cut_off_json_of_any_shape_is_named_with_line_and_column(
    content: str, tmp_path: Path
) -> None:
    (tmp_path / "x").write_text(content)
    refused(tmp_path / "x", r"x: broken JSON at line 1, column \d+ .*cut off")


def test_a_file_without_permission_gives_a_one_line_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "locked"
    path.write_text(NATIVE)

    def deny(*_: object) -> None:
        raise PermissionError(13, "Permission denied")  # what open does for anyone but root

    monkeypatch.setattr(data_file, "open", deny, raising=False)
    refused(path, "locked: no permission to read it")


def test_a_file_too_large_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for content in (NATIVE, EVENT_LIST):
        with open(tmp_path / "big", "wb") as stream:
            stream.write(content.encode())
            stream.truncate(data_file.MAX_WHOLE_BYTES + 1)  # sparse: takes no space
        monkeypatch.setattr(data_file, "HEAD_BYTES", len(content))
        refused(
            tmp_path / "big",
            r"big: 64 MB, more than the 64 MB that are read; .*\(--read max-mb=MB\)",
        )


def test_a_name_that_is_not_utf8_is_printable(tmp_path: Path) -> None:
    name = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.json")
    try:
        Path(name).write_text('{"a": 1}')
    except OSError:
        pytest.skip("this file system takes UTF-8 names only")
    refused(name, r"caf\\xe9\.json: a JSON object")
    refused(name + "x", r"caf\\xe9\.jsonx: no such file")
    Path(name).write_text(NATIVE)
    assert load_timeline(name).title == r"caf\xe9"


def test_a_duration_is_taken_only_by_formats_that_lack_one(tmp_path: Path) -> None:
    (tmp_path / "x").write_text(NATIVE)
    refused(tmp_path / "x", "native timeline .*duration_s does not apply", duration_s=5.0)
    (tmp_path / "x").write_text(EVENT_LIST)
    assert load_timeline(tmp_path / "x", duration_s=5.0).duration_s == 5.0
    for bad in (0.0, -1.0, float("nan"), "5"):
        refused(tmp_path / "x", "duration_s is", duration_s=bad)


def test_a_new_format_needs_only_one_entry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read(found: data_file.DataFile, options: data_file.LoadOptions) -> Any:
        return loading.bundled_timeline()

    extra = Format("shout", lambda found: found.head.startswith(b"HEY"), read)
    monkeypatch.setattr(formats, "FORMATS", (*FORMATS, extra))
    (tmp_path / "x").write_bytes(b"HEY")
    assert load_timeline(tmp_path / "x").title.startswith("France 4-2 Croatia")


def test_importing_timelines_is_light() -> None:
    code = (
        "import sys, overview_dsp.data.timeline; "
        "print([m for m in ('pandas', 'scipy', 'numba', 'pydantic', 'matplotlib') "
        "if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    # the package's own __init__ may bring more in: only what timeline itself adds counts
    base = code.replace(", overview_dsp.data.timeline", ", overview_dsp")
    alone = subprocess.run([sys.executable, "-c", base], capture_output=True, text=True, check=True)
    assert found.stdout == alone.stdout


@pytest.mark.parametrize("name", ["MAC address", "ID3", "fLaC"])
def test_a_table_whose_header_is_the_mark_of_a_sound_is_a_table(name: str) -> None:
    text = f"{name},time,level\n" + "".join(f"a,{10 * i},{i * i}\n" for i in range(5))
    curve = load_timeline(text.encode(), value="level", time="time").intensity
    assert curve is not None
    assert curve.value.tolist() == [0.0, 1.0, 4.0, 9.0, 16.0]


@pytest.mark.parametrize("digits", [308, 310, 350, 400, 5000])
def test_a_number_of_any_length_in_json_gives_a_one_line_error(digits: int) -> None:
    rows = f'[{{"time": 1, "value": {"9" * digits}}}, {{"time": 2, "value": 3}}]'
    with pytest.raises(InputError) as caught:
        load_timeline(rows.encode())
    assert "\n" not in str(caught.value)


def test_a_log_of_an_old_windows_is_text(tmp_path: Path) -> None:
    lines = [f"[03.05.24, 18:{20 + i}] Müller: Grüße {i}" for i in range(5)]
    (tmp_path / "chat.txt").write_bytes("\n".join(lines).encode("cp1252"))
    curve = load_timeline(tmp_path / "chat.txt", map="count").intensity
    assert curve is not None
    assert curve.time_s[-1] >= 240.0
