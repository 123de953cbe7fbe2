"""Drawing in the window and on sheets: theme, dials, small controls, plots."""
