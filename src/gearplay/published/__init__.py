"""Published studies, reproduced and compared with what was printed."""
