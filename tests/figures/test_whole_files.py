"""No stop leaves half a file, nor loses the old one."""

import pytest

import whole_files


def test_a_file_takes_the_place_of_the_old_one_when_it_is_whole(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("old")
    with whole_files.replacing(page) as partial:
        partial.write_text("new")
        assert partial.suffix == ".md" and page.read_text() == "old"
    assert page.read_text() == "new"
    assert list(tmp_path.iterdir()) == [page]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, SystemExit, OSError])
def test_a_stop_leaves_the_old_file_and_no_other(tmp_path, stop):
    page = tmp_path / "page.md"
    page.write_text("old")
    with pytest.raises(stop):
        with whole_files.replacing(page) as partial:
            partial.write_text("half")
            raise stop
    assert page.read_text() == "old"
    assert list(tmp_path.iterdir()) == [page]
