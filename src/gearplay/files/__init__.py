"""Files: measurement formats, plans, folders, atomic writing."""
