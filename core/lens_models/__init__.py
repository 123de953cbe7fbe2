"""Faster stand-ins for a traced lens: fitted polynomial and table of rays."""
