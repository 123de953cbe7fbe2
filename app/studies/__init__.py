"""Measurements of the program itself: speed and accuracy charts, stability sweeps and the benchmark."""
