"""Light fields, lumigraphs and the plenoptic camera: capture once, refocus afterwards."""
