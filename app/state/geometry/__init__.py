"""Curves and regions that the panels draw, from the settings: section, plan, rays, exit pupil, blur. No window."""
