"""Lens files of lensbench and of other programs: a reader for each format, a writer where there is one."""
