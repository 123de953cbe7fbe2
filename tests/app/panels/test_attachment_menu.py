"""The menu *Attach* of the table of surfaces: each item gives a lens without a fault."""

from lensbench import lenses
from lensbench.app.panels.lens_table.menu import attachment_edits
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.editing.faults import faults


def test_everything_that_is_offered_can_be_attached():
    for name in ("lenshh-cooke-triplet-50", "pbrt-wide-22mm"):
        document = LensDocument(lenses.load(name))
        for title, edit in attachment_edits(document):
            after = edit(document)
            assert len(after.surfaces) == len(document.surfaces) + 2, title
            assert {f.kind for f in faults(after)} <= {f.kind for f in faults(document)}, title
