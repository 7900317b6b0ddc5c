"""Integration of the motion: contact states, explicit and implicit steps, events, samples, derivative."""
