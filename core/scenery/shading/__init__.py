"""Stages that find the light that an intersection sends along a ray."""
