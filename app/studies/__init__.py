"""Measurements of the program itself: charts, stability and benchmark."""
