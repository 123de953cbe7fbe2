"""The control column: dials and the popups beside them."""
