"""Background work: rendering, light fields, charts, and the warm-up of the kernel cache."""
