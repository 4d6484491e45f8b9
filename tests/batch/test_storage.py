from __future__ import annotations

import os
import shutil
import threading

import pytest

import overview_dsp as ov
from overview_dsp.batch.storage import Storage


@pytest.mark.parametrize("written", ["{}", "{}/", "../{name}", "."])
def test_storage_lists_files_by_their_path_below_the_folder(tmp_path, monkeypatch, written):
    monkeypatch.chdir(tmp_path)
    place = Storage(written.format(tmp_path, name=tmp_path.name))
    place.put("sounds/ab/a.wav", b"123")
    place.put("sounds/b.wav", b"")
    place.put("manifest", b"1")
    assert place.sizes("sounds") == {"sounds/ab/a.wav": 3, "sounds/b.wav": 0}
    assert place.sizes("parts") == place.sizes("manifest") == {}


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads all")
def test_a_folder_that_cannot_be_read_is_an_error_of_one_line(tmp_path):
    (tmp_path / "sounds").mkdir(mode=0)
    with pytest.raises(ov.InputError, match="sounds: can't be read"):
        Storage(str(tmp_path)).sizes("sounds")


def test_folders_that_another_process_deletes_are_made_again(tmp_path):
    place = Storage(str(tmp_path / "study"))
    for _ in range(3):
        place.put("sounds/ab/a.wav", b"123")
        assert place.sizes("sounds") == {"sounds/ab/a.wav": 3}
        shutil.rmtree(tmp_path / "study")
    place.put("manifest", b"1")
    place.clean()
    place.put("sounds/ab/a.wav", b"123")


def test_files_are_written_while_another_process_cleans_up(tmp_path):
    place, other = Storage(str(tmp_path)), Storage(str(tmp_path))
    over = threading.Event()

    def clean():
        while not over.wait(0.002):
            other.clean()

    cleaning = threading.Thread(target=clean)
    cleaning.start()
    try:
        for number in range(500):
            place.put(f"sounds/{number % 7}/{number}.wav", b"123")
    finally:
        over.set()
        cleaning.join()
    assert len(place.sizes("sounds")) == 500
