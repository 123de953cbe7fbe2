"""The camera strip: it shows an f-number where one can be set."""

from dataclasses import replace

import pytest

from lensbench.app.bench.exposure import AppliedExposure
from lensbench.app.panels.image.camera_strip import strip_values
from tests.app.conftest import SMALL
from tests.app.kinds import KINDS, of_kind


@pytest.mark.parametrize("kind", KINDS)
def test_a_camera_has_an_f_number_where_that_opens_its_stop(kind):
    settings = replace(of_kind(SMALL, kind), f_number=4.0)
    names = [value.name for value in strip_values(settings, "off", AppliedExposure(1.0, 100.0, None))]
    opens = kind in ("auto", "trace", "polynomial", "thick", "thin", "perspective")
    assert ("f-number" in names) is opens
    assert "Time" in names
