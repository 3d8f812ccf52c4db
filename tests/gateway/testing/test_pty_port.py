import pytest

from gaitway.testing.pty_port import PtyPort


def test_a_file_that_is_no_link_is_never_replaced(tmp_path):
    file = tmp_path / "keep.txt"
    file.write_text("precious")
    with pytest.raises(FileExistsError, match=r"keep\.txt"):
        PtyPort(file)
    assert file.read_text() == "precious"


def test_a_link_left_behind_is_taken_over_and_removed_on_unplugging(tmp_path):
    link = tmp_path / "port"
    link.symlink_to("/dev/pts/nowhere")
    with PtyPort(link):
        assert link.exists()
    assert not link.is_symlink()
