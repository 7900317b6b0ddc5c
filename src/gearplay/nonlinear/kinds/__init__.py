"""Classification of motions, with the evidence."""
