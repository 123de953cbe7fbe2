"""Exit-pupil regions: solvers and samplers of the area through which light from a film point leaves the lens."""
