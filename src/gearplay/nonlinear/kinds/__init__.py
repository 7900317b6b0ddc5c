"""What kind of motion it is, with the evidence."""
