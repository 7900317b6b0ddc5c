"""Cases simulated, reduced to what is kept, stored and put together."""
