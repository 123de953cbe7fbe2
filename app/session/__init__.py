"""What a user keeps: history, files, snapshots, edited lenses, pictures and recordings."""
