"""Pictures of nonlinear analysis."""
