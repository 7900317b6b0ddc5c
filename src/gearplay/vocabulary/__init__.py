"""Words every floor shares: the errors and the one table of quantities.

This floor imports nothing else of the package.
"""
