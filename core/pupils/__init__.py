"""Exit-pupil regions: where the light of a film point leaves the lens, solved and sampled."""
