"""The lens section with traced rays and cardinal points."""
