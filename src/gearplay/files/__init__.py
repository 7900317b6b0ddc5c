"""Files: measurement formats, plans, folders and the way to a file that is either whole or absent."""
