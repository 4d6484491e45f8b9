from __future__ import annotations

import errno
import os

import pytest

import overview_dsp as ov
from overview_dsp.files.atomic import atomic_file, make_folder


def write(path, text="new") -> None:
    with atomic_file(path) as temporary:
        temporary.write_text(text)


def test_a_file_appears_when_it_is_whole_and_not_before(tmp_path):
    path = tmp_path / "a.txt"
    with atomic_file(path) as temporary:
        temporary.write_text("new")
        assert not path.exists()
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".txt"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_was_there_is_replaced(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old and longer")
    write(path)
    assert path.read_text() == "new"


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, ov.InputError])
def test_an_error_while_writing_leaves_the_existing_file(tmp_path, error):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail() -> None:
        with atomic_file(path) as temporary:
            temporary.write_text("half")
            raise error("x")

    with pytest.raises(error):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("code", "kind"),
    [
        (errno.ENOSPC, ov.OutputError),
        (errno.EIO, ov.OutputError),
        (errno.EFBIG, ov.OutputError),
        (errno.EACCES, ov.InputError),
        (errno.EROFS, ov.InputError),
    ],
)
def test_the_disks_fault_and_the_callers_fault_are_distinguished(tmp_path, code, kind):
    path = tmp_path / "a.txt"

    def fail() -> None:
        with atomic_file(path):
            raise OSError(code, os.strerror(code))

    with pytest.raises(kind, match=r"a\.txt") as error:
        fail()
    assert os.strerror(code) in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_a_file_has_the_rights_that_the_umask_leaves(tmp_path):
    before = os.umask(0o027)
    try:
        write(tmp_path / "a.txt")
    finally:
        os.umask(before)
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("name", ["no/a.txt", "file/a.txt", "", "x" * 5000, "a\0b", "n" * 300])
def test_an_invalid_path_is_an_error_of_one_line(tmp_path, name):
    (tmp_path / "file").write_text("")
    with pytest.raises(ov.InputError) as error:
        write(tmp_path / name)
    assert "\n" not in str(error.value)
    assert (tmp_path / "file").exists()
    assert len(list(tmp_path.iterdir())) == 1


def test_a_name_as_long_as_the_folder_allows_is_fine(tmp_path):
    name = "n" * 251 + ".txt"
    write(tmp_path / name)
    assert (tmp_path / name).read_text() == "new"


def test_a_folder_is_made_with_its_parents_and_may_be_there(tmp_path):
    made = make_folder(tmp_path / "a" / "b")
    assert made.is_dir()
    assert make_folder(str(made)) == made


def test_a_folder_in_a_files_place_is_an_error_of_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    for name in ("file", "file/sub"):
        with pytest.raises(ov.InputError, match="can't be written") as error:
            make_folder(tmp_path / name)
        assert "\n" not in str(error.value)
