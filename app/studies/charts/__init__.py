"""Charts of speed against accuracy: what is measured (`models`, …), the values, their drawing and their table."""
