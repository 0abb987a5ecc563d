"""hf sample: writes whole files, leaves the same ones alone, and never destroys somebody's work."""

import pytest

from hyperfab.cases.about import SampleCase
from hyperfab.chapters import sample
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.errors import OutputError, UsageError
from hyperfab.samples import sample_files


def write(folder, force=False):
    return sample.run(Job("sample", [], Console(quiet=True)), SampleCase(folder=str(folder), force=force))


def test_writes_every_sample(tmp_path):
    assert write(tmp_path / "new" / "place") == 0
    for path, data in sample_files().items():
        assert (tmp_path / "new" / "place" / path).read_bytes() == data


def test_leaves_files_alone_that_are_there_already(tmp_path):
    write(tmp_path)
    foam = tmp_path / "specimens" / "foam.csv"
    before = foam.stat().st_mtime_ns
    assert write(tmp_path) == 0
    assert foam.stat().st_mtime_ns == before


def test_refuses_to_overwrite_a_file_that_differs_and_then_writes_nothing(tmp_path):
    foam = tmp_path / "specimens" / "foam.csv"
    foam.parent.mkdir()
    foam.write_text("mine")
    with pytest.raises(UsageError, match=r"foam\.csv.*--force"):
        write(tmp_path)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["foam.csv"]
    assert write(tmp_path, force=True) == 0
    assert foam.read_bytes() == sample_files()["specimens/foam.csv"]


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="is a file"):
        write(tmp_path / "file")


def test_a_folder_that_cannot_be_made_is_an_output_error(tmp_path):
    (tmp_path / "specimens").write_text("")
    with pytest.raises(OutputError, match="choose another folder"):
        write(tmp_path)
