"""Which cases a plan means, and what each is called."""
