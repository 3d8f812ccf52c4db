import os

import pytest

from gaitway.recording import retention
from gaitway.recording.params import RecordingParams
from gaitway.recording.retention import make_room, recordings

DAY_NS = 86_400 * 10**9
NOW_NS = 1_767_225_600 * 10**9


@pytest.fixture
def add(tmp_path):
    """Returns a function that makes a finished recording of some age and size."""

    def make(number, age_days, size=1000, name=None):
        path = tmp_path / (name or f"20251201T000000Z-cafe-{number}.mcap")
        path.write_bytes(bytes(size))
        modified_ns = round(NOW_NS - age_days * DAY_NS)
        os.utime(path, ns=(modified_ns, modified_ns))
        return path

    return make


@pytest.fixture
def free(monkeypatch):
    """Returns a function that sets how much of the disk seems free."""

    def set_free(of_directory):
        monkeypatch.setattr(retention, "free_bytes", of_directory)

    return set_free


def settings(directory, **changes):
    values = {"directory": directory, "min_free_gb": 0.0, "max_file_mb": 0.1} | changes
    return RecordingParams(**values)


def left(directory):
    return {int(path.stem.split("-")[2]) for path in directory.iterdir()}


def test_what_is_older_than_max_age_goes_and_the_rest_stays(tmp_path, add):
    for number in range(10):
        add(number, age_days=10 - number)
    make_room(settings(tmp_path, max_age_days=4.5), NOW_NS)
    assert left(tmp_path) == {6, 7, 8, 9}


def test_the_oldest_go_until_all_recordings_fit_with_the_next_one(tmp_path, add):
    for number in range(10):
        add(number, age_days=10 - number, size=100_000)
    make_room(settings(tmp_path, max_total_gb=0.0006), NOW_NS)
    assert left(tmp_path) == {5, 6, 7, 8, 9}


def test_the_oldest_go_until_the_reserve_is_free(tmp_path, add, free):
    for number in range(10):
        add(number, age_days=10 - number)
    free(lambda directory: 2e9 - 1e6 * (len(list(directory.iterdir())) - 4))
    make_room(settings(tmp_path, min_free_gb=2.0), NOW_NS)
    assert left(tmp_path) == {6, 7, 8, 9}


def test_all_go_if_even_that_does_not_free_the_reserve(tmp_path, add, free):
    for number in range(3):
        add(number, age_days=0.1)
    free(lambda _: 0)
    make_room(settings(tmp_path, min_free_gb=2.0), NOW_NS)
    assert left(tmp_path) == set()


@pytest.mark.parametrize(
    "name",
    [
        "20251201T000000Z-cafe-0.mcap.active",
        "20251201T000000Z-cafe-0.mcap.broken",
        "20251201T000000Z-cafe-0.mcap.recovering",
        "my-walk.mcap",
        "copy of 20251201T000000Z-cafe-0.mcap",
        "20251201T000000Z-cafe-0.mcap.bak",
        "20251201-cafe-0.mcap",
        "notes.txt",
    ],
)
def test_what_is_not_a_finished_recording_of_ours_is_never_deleted(tmp_path, add, free, name):
    path = add(0, age_days=1000, name=name)
    free(lambda _: 0)
    make_room(settings(tmp_path, min_free_gb=2.0, max_age_days=1), NOW_NS)
    assert path.exists()


def test_a_folder_or_link_with_our_name_is_never_deleted(tmp_path, add, free, caplog):
    (tmp_path / "20251201T000000Z-cafe-1.mcap").mkdir()
    target = add(0, age_days=1000, name="elsewhere")
    (tmp_path / "20251201T000000Z-cafe-2.mcap").symlink_to(target)
    free(lambda _: 0)
    make_room(settings(tmp_path, min_free_gb=2.0), NOW_NS)
    assert len(list(tmp_path.iterdir())) == 3
    assert caplog.records == []


def test_a_file_of_a_clock_that_was_not_set_is_not_too_old(tmp_path, add):
    """A Pi without a clock of its own begins in 1970."""
    add(0, age_days=NOW_NS / DAY_NS - 1)
    add(1, age_days=100)
    add(2, age_days=1)
    make_room(settings(tmp_path, max_age_days=30), NOW_NS)
    assert left(tmp_path) == {0, 2}


def test_recordings_of_one_second_are_ordered_by_their_number(tmp_path, add):
    for number in (10, 9, 2, 1):
        add(number, age_days=1)
    assert [int(found.path.stem.split("-")[2]) for found in recordings(tmp_path)] == [1, 2, 9, 10]


def test_a_file_that_cannot_be_deleted_does_not_stop_the_others(tmp_path, add, monkeypatch):
    stubborn = add(0, age_days=100)
    add(1, age_days=90)
    unlink = type(stubborn).unlink

    def refuse(path, missing_ok=False):
        if path == stubborn:
            raise PermissionError(13, "Permission denied", str(path))
        unlink(path, missing_ok)

    monkeypatch.setattr(type(stubborn), "unlink", refuse)
    assert [path.name[-6:] for path in make_room(settings(tmp_path), NOW_NS)] == ["1.mcap"]
    assert left(tmp_path) == {0}


def test_thousands_of_small_files_are_brought_within_bounds_at_once(tmp_path, add):
    for number in range(3000):
        add(number, age_days=0.001 * (3000 - number), size=300)
    make_room(settings(tmp_path, max_total_gb=0.0004, max_age_days=1.0), NOW_NS)
    assert left(tmp_path) == set(range(2000, 3000))


def test_a_total_that_does_not_hold_two_files_is_refused(tmp_path):
    with pytest.raises(ValueError, match="does not hold two files of"):
        RecordingParams(directory=tmp_path, max_total_gb=0.4, max_file_mb=256)
