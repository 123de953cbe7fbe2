"""The progressive picture, its auxiliary output variables (AOVs), and light tracing."""
