"""Lens files shipped with lensbench."""
