"""Stages that find where rays meet objects."""
