"""Glasses: catalogues, the AGF format, and media as lens files name them."""
