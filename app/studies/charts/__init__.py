"""Charts of speed against accuracy: measurement, values, drawing and tables."""
