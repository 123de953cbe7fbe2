"""The start of the window: garbage is searched for again as soon as everything is loaded, also after an error."""

import gc

import pytest

from lensbench.app.command.main import loading


def test_the_search_for_garbage_goes_on_after_loading():
    before = gc.get_freeze_count()
    try:
        with loading():
            assert not gc.isenabled()
        assert gc.isenabled() and gc.get_freeze_count() > before
    finally:
        gc.unfreeze()


def test_the_search_for_garbage_goes_on_after_an_error_of_the_user():
    with pytest.raises(ValueError, match="no such lens"), loading():
        raise ValueError("no such lens")
    assert gc.isenabled()
