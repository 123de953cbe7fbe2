"""The analysis panels: one file a panel, its choices and gestures; `drawing` draws every figure."""
