"""Lens prescriptions as data, and the readers and writers of lens files."""
