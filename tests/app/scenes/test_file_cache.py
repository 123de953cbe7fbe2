"""A file that cannot be read after a change leaves its last good content in use."""

import pytest

from lensbench.app.scenes.asset_files import keeps_last_good


def test_the_last_good_content_stays_until_the_file_can_be_read_again():
    contents, reads = {("a", 1): "one", ("a", 3): "three"}, []

    @keeps_last_good(4)
    def load(name, stamp):
        reads.append((name, stamp))
        if (name, stamp) not in contents:
            raise ValueError(f"{name}: half written")
        return contents[name, stamp]

    assert [load("a", stamp) for stamp in (1, 1, 2, 2, 3, 1)] == ["one", "one", "one", "one", "three", "one"]
    assert reads == [("a", 1), ("a", 2), ("a", 3)]              # each state of the file is read once
    with pytest.raises(ValueError, match="b: half written"):
        load("b", 1)
    contents["b", 1] = "now"
    assert load("b", 1) == "now"


def test_contents_of_files_that_were_left_long_ago_go():
    reads = []

    @keeps_last_good(2)
    def load(name, stamp):
        reads.append(name)
        if stamp:
            raise ValueError(f"{name}: half written")
        return name.upper()

    for name in "abca":
        assert load(name, 0) == name.upper()
    assert reads == ["a", "b", "c", "a"]
    assert load("a", 1) == "A"                          # one of the two newest
    with pytest.raises(ValueError, match="b: half"):
        load("b", 1)
