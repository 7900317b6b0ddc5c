"""Long work: executors, stores of finished pieces, resumable output folders, progress and cancellation."""
