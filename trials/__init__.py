"""Long trials, which `make test` leaves out: fuzzing the readers (make fuzz), and peers side by side (make peers)."""
