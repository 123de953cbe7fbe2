"""Two settings compared: the dials that A takes from B, and the differences of their figures."""
