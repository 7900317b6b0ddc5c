"""Involute gears as drawings give them: geometry of a pair, allowances, stiffness from the teeth."""
