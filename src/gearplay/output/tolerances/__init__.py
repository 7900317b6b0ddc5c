"""What tolerance answers write: figures, sentences and page."""
