"""The interactive page: a local server, its worker processes, and the page itself (`static`)."""
