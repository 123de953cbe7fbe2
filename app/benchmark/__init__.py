"""The benchmark `lensbench bench`: speed, as ratios within one run."""
